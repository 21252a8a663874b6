"""From a contact that opens to a sphere in free flight: tubes without pushers, and the magnet."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulators.world.description import Environment, Magnet, Sphere, TiltedTubes
from simulators.world.launch import Departure
from simulators.world.rotation import random_orientation
from simulators.world.state import Motion

FLAT_M = 1000.0
"""Radius of the sphere that stands for a plate."""


@dataclass(frozen=True, slots=True)
class Release:
    """Lab times at which the holders of a and b were switched; None: that sphere stays.

    `angles_deg` are the tilts of both tubes as somebody has turned them; None: as described.

    Raises
    ------
    ValueError
        Neither was.
    """

    fire_a_s: float | None
    fire_b_s: float | None
    angles_deg: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.fire_a_s is None and self.fire_b_s is None:
            raise ValueError("no holder was switched")

    @property
    def starts_s(self) -> float:
        """Lab time from which the shot's own times count: the first of the two."""
        return min(time for time in (self.fire_a_s, self.fire_b_s) if time is not None)


@dataclass(frozen=True, slots=True)
class Held:
    """A sphere in its tilted tube; `toward` is +1 for the left tube (a) and -1 for the right."""

    tubes: TiltedTubes
    sphere: Sphere
    angle_deg: float
    toward: float


def roll(
    held: Held, switched_s: float, environment: Environment, rng: np.random.Generator
) -> Departure:
    """Let a sphere roll out of its tube, without slipping, with the scatter of a real one."""
    tubes, sphere = held.tubes, held.sphere
    scatter = rng.normal(size=6)
    odd_spin = tubes.spin_scatter_rad_per_s * rng.normal(size=3)
    orientation = random_orientation(rng)
    angle = math.radians(held.angle_deg)
    pull = environment.gravity_m_per_s2 * math.sin(angle) / (1.0 + sphere.inertia_factor)
    speed = math.sqrt(2.0 * pull * tubes.length_m) * (1.0 + tubes.speed_scatter * scatter[0])
    tilt_x, tilt_z = tubes.direction_scatter_rad * scatter[1:3]
    shift_x, shift_z = tubes.position_scatter_m * scatter[3:5]
    direction = np.array([math.sin(angle) + tilt_x, held.toward * math.cos(angle), tilt_z])
    velocity = speed * direction / np.linalg.norm(direction)
    # The tube carries the sphere from below; the point that touches it stands still.
    below = np.array([math.cos(angle), -held.toward * math.sin(angle), 0.0])
    spin = np.cross(velocity, below) / sphere.radius_m + odd_spin
    centre = np.array([tubes.height_m + shift_x, -held.toward * tubes.mouth_m, shift_z])
    starts_s = switched_s + tubes.release_delay_s + tubes.release_jitter_s * float(scatter[5])
    way_s = 2.0 * tubes.length_m / speed
    return Departure(
        starts_s=starts_s,
        exit_s=starts_s + way_s,
        exit=Motion(centre, velocity, orientation, spin),
        push_s=way_s,
        stroke_m=tubes.length_m,
    )


def let_go(magnet: Magnet, switched_s: float, rng: np.random.Generator) -> tuple[float, Motion]:
    """Return when the magnet's sphere is loose, and its motion then: at rest but for scatter."""
    scatter = rng.normal(size=5)
    spin = magnet.spin_scatter_rad_per_s * rng.normal(size=3)
    place = np.array([magnet.height_m, *(magnet.position_scatter_m * scatter[:2])])
    velocity = np.array([0.0, *(magnet.drift_scatter_m_per_s * scatter[2:4])])
    delay_s = magnet.release_delay_s + magnet.release_jitter_s * float(scatter[4])
    return switched_s + max(delay_s, 0.0), Motion(place, velocity, random_orientation(rng), spin)


PLATE = Sphere(diameter_m=2.0 * FLAT_M, density_kg_per_m3=1.0e5, markers=0)
"""Flat over the contact of a ball, and too heavy to move, to one part in 10^5."""


def plate_below(magnet: Magnet, centre: NDArray[np.float64]) -> Motion:
    """Return the plate at rest, level below a centre (3,)."""
    still = np.zeros(3)
    upright = np.array([1.0, 0.0, 0.0, 0.0])
    return Motion(np.array([magnet.plate_m + FLAT_M, *centre[1:]]), still, upright, still)
