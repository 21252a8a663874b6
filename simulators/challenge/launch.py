"""Settings of a campaign in random order, and the spheres at first touch as the launch left them.

Flight is reversible, so a shot is drawn at its first touch and followed from there both ways.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulators.world.description import Sphere, Tube
from simulators.world.launch import muzzle_speed

Floats = NDArray[np.float64]

PRESSURES_KPA = (12.0, 95.0)
FILMED_PRESSURES_KPA = (12.0, 30.0)
"""Of campaigns in frames: at 1000 frames/s an outline is followed through a contact only where it
leaves its straight way by less than a third of its radius in a frame, up to 2.5 m/s."""
_OFFSETS_MM = (0.0, 22.0)
_STROKE_M = 0.018
"""Long, for 1.1 to 4.8 m/s: air shows itself at high speed only."""
_TUBE_SPIN_RAD_PER_S = 110.0
"""About half of what rolling along the tube would give."""
_FALL_M_PER_S = 0.25
"""Speed that gravity gives between the mouths and the contact."""


@dataclass(frozen=True, slots=True, eq=False)
class Settings:
    """What a laboratory notes of S shots, each (S,), in the order of firing."""

    pressure_kpa: Floats
    offset_mm: Floats
    temperature_c: Floats

    @property
    def order(self) -> Floats:
        """Place in the campaign, from -0.5 to 0.5."""
        return np.linspace(-0.5, 0.5, len(self.offset_mm))


@dataclass(frozen=True, slots=True, eq=False)
class Touch:
    """Both spheres of S shots at first touch, a before b, in rig axes.

    Parameters
    ----------
    point
        Where they touch, m, (S, 3).
    normal
        Unit vector from a to b, (S, 3).
    velocity, spin
        m/s and rad/s, (S, 2, 3).
    """

    point: Floats
    normal: Floats
    velocity: Floats
    spin: Floats

    @property
    def approach(self) -> Floats:
        """Approach speed v_n, m/s, positive, (S,)."""
        closing = self.velocity[:, 1] - self.velocity[:, 0]
        return np.asarray(-np.einsum("si,si->s", closing, self.normal))

    def slip(self, radius_m: float) -> Floats:
        """Return the velocity (S, 3), m/s, of the surface of b over that of a."""
        closing = self.velocity[:, 1] - self.velocity[:, 0]
        across = closing + self.approach[:, None] * self.normal
        return np.asarray(across + radius_m * np.cross(self.normal, self.spin.sum(axis=1)))


def draw_settings(
    shots: int, rng: np.random.Generator, pressures_kpa: tuple[float, float] = PRESSURES_KPA
) -> Settings:
    """Spread pressures and offsets evenly over their ranges, each in an order of its own."""
    share = (np.arange(shots) + 0.5) / shots
    low, high = pressures_kpa
    least, most = _OFFSETS_MM
    hours = np.arange(shots) / 60.0
    swing = np.sin(2 * np.pi * (hours / 0.7 + rng.uniform()))
    return Settings(
        pressure_kpa=np.round(rng.permutation(low + (high - low) * share), 1),
        offset_mm=np.round(rng.permutation(least + (most - least) * share), 2),
        temperature_c=np.round(23.0 + 2.0 * swing + rng.normal(0.0, 0.3, shots), 2),
    )


def draw_touch(settings: Settings, sphere: Sphere, rng: np.random.Generator) -> Touch:
    """Draw how the spheres meet, with the scatter of the launch about the settings."""
    shots = len(settings.offset_mm)
    tube = Tube(stroke_m=_STROKE_M)
    mean = np.array([muzzle_speed(float(p), sphere, tube) for p in settings.pressure_kpa])
    speed = mean[:, None] * (1.0 + rng.normal(0.0, tube.speed_scatter, (shots, 2)))
    velocity = rng.normal(0.0, 4 * tube.direction_scatter_rad, (shots, 2, 3)) * speed[..., None]
    velocity[..., 1] = speed * np.array([1.0, -1.0])
    velocity[..., 0] += _FALL_M_PER_S
    normal = np.zeros((shots, 3))
    normal[:, 0] = settings.offset_mm * 1e-3 + rng.normal(0.0, 2e-4, shots)
    normal[:, 2] = rng.normal(0.0, 4e-4, shots)
    normal /= sphere.diameter_m
    normal[:, 1] = np.sqrt(1.0 - (normal**2).sum(axis=1))
    return Touch(
        point=rng.normal(0.0, [1e-3, 2e-3, 1e-3], (shots, 3)),
        normal=normal,
        velocity=velocity,
        spin=rng.normal(0.0, _TUBE_SPIN_RAD_PER_S, (shots, 2, 3)),
    )
