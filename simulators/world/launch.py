"""From the pulse on a pusher to a sphere in free flight."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulators.world.description import Sphere, Tube
from simulators.world.rotation import random_orientation, turn
from simulators.world.state import Motion, Pose


@dataclass(frozen=True, slots=True)
class Launch:
    """The settings of one shot, and the lab times of the two pulses.

    Pressures are kPa gauge. Tube b sits `offset_m` lower (larger X) than tube a; the axes lie
    half of it above and below the common height.
    """

    pressure_a_kpa: float
    pressure_b_kpa: float
    offset_m: float
    fire_a_s: float = 0.0
    fire_b_s: float = 0.0

    @property
    def starts_s(self) -> float:
        """Lab time from which the shot's own times count."""
        return self.fire_a_s


@dataclass(frozen=True, slots=True)
class Departure:
    """One sphere's way through its tube, from the pulse to the centre's passing the mouth.

    Times are in the clock of the caller. `exit` is the motion at `exit_s`; `starts_s` is when the
    sphere begins to move, after which it may be seen.
    """

    starts_s: float
    exit_s: float
    exit: Motion
    push_s: float
    stroke_m: float

    def at(self, time_s: float) -> Pose:
        """Return the pose in the tube; the spin grows with the way, as in rolling."""
        speed = float(np.linalg.norm(self.exit.velocity))
        since = time_s - self.starts_s
        if since < self.push_s:
            to_go = self.stroke_m * (1.0 - (since / self.push_s) ** 2)
            to_go += speed * (self.exit_s - self.starts_s - self.push_s)
        else:
            to_go = speed * (self.exit_s - time_s)
        lead = to_go / speed
        return Pose(
            self.exit.centre - self.exit.velocity * lead,
            turn(-self.exit.spin * lead, self.exit.orientation),
        )


def muzzle_speed(pressure_kpa: float, sphere: Sphere, tube: Tube) -> float:
    """Return the mean muzzle speed in m/s; zero where the pressure cannot move the sphere.

    The pusher's work less the losses becomes kinetic energy: v = sqrt(2 (p A - F) s / m).
    """
    force = pressure_kpa * 1000.0 * tube.piston_area_m2 - tube.friction_n
    return math.sqrt(2.0 * max(force, 0.0) * tube.stroke_m / sphere.mass_kg)


@dataclass(frozen=True, slots=True)
class Loaded:
    """A tube with its sphere in it, ready to fire.

    `height_m` is X of the tube's axis; `toward` is +1 for the left tube (sphere a, toward +Y) and
    -1 for the right one.
    """

    tube: Tube
    sphere: Sphere
    height_m: float
    toward: float


def depart(
    loaded: Loaded, pressure_kpa: float, fire_s: float, rng: np.random.Generator
) -> Departure | None:
    """Push one sphere out of its tube, with the scatter of a real pusher.

    Returns
    -------
    None if the pressure is too low to move the sphere.
    """
    tube, sphere = loaded.tube, loaded.sphere
    # Every draw is made for every shot, so that one setting does not shift another's scatter.
    scatter = rng.normal(size=6)
    spin = tube.spin_scatter_rad_per_s * rng.normal(size=3)
    orientation = random_orientation(rng)
    speed = muzzle_speed(pressure_kpa, sphere, tube) * (1.0 + tube.speed_scatter * scatter[0])
    if speed <= 0.0:
        return None
    tilt_x, tilt_z = tube.direction_scatter_rad * scatter[1:3]
    shift_x, shift_z = tube.position_scatter_m * scatter[3:5]
    push_s = 2.0 * tube.stroke_m / speed
    coast_s = max(sphere.radius_m - tube.stroke_m, 0.0) / speed
    starts_s = fire_s + tube.valve_delay_s + tube.valve_jitter_s * float(scatter[5])
    centre = np.array([loaded.height_m + shift_x, -loaded.toward * tube.mouth_m, shift_z])
    direction: NDArray[np.float64] = np.array([tilt_x, loaded.toward, tilt_z])
    velocity = speed * direction / np.linalg.norm(direction)
    return Departure(
        starts_s=starts_s,
        exit_s=starts_s + push_s + coast_s,
        exit=Motion(centre, velocity, orientation, spin),
        push_s=push_s,
        stroke_m=tube.stroke_m,
    )
