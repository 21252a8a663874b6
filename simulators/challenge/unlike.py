"""Two spheres of unlike size and mass that meet in free fall, followed through their contact.

Both bodies are moved by small steps of all forces on each of them; no reduced mass, no relative
motion. X points down.

References
----------
Cundall, Strack, Geotechnique 29 (1979) 47-65; Tsuji, Tanaka, Ishida, Powder Technology 71 (1992)
239-250.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from simulators.challenge.vectors import cross

Floats = NDArray[np.float64]

GRAVITY = 9.80665
_STEPS = 3000
"""In an undamped contact."""


@dataclass(frozen=True, slots=True)
class Pair:
    """Two solid spheres a and b, and how they press each other.

    Parameters
    ----------
    radii_m, densities_kg_per_m3
        Of a and b; moments of inertia are 0.4 m r^2.
    duration_s
        Of an undamped contact at 1 m/s.
    damping
        Dashpot of Tsuji over its critical value: e is the same at every speed.
    friction, stiffness_ratio, tangential_damping
        mu, kt / kn, and the tangential dashpot over its critical value.
    """

    radii_m: tuple[float, float] = (0.0127, 0.008)
    densities_kg_per_m3: tuple[float, float] = (1150.0, 2500.0)
    duration_s: float = 2.0e-4
    damping: float = 0.13
    friction: float = 0.12
    stiffness_ratio: float = 0.4
    tangential_damping: float = 0.06

    @property
    def masses_kg(self) -> Floats:
        """Of a and b, shape (2,)."""
        volumes = 4 / 3 * np.pi * np.array(self.radii_m) ** 3
        return np.asarray(volumes * self.densities_kg_per_m3)

    @property
    def inertias(self) -> Floats:
        """Moments of inertia of a and b, kg m^2, shape (2,)."""
        return np.asarray(0.4 * self.masses_kg * np.array(self.radii_m) ** 2)


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Centres, velocities and spins of a and b, each of shape (2, 3): m, m/s, rad/s; how turned."""

    places: Floats
    velocities: Floats
    spins: Floats
    turned: tuple[Rotation, Rotation]

    def later(self, time: float) -> Motion:
        """Return where free flight takes both; a negative time goes back."""
        fall = np.array([GRAVITY, 0.0, 0.0])
        return Motion(
            self.places + self.velocities * time + 0.5 * fall * time**2,
            self.velocities + fall * time,
            self.spins,
            (
                Rotation.from_rotvec(self.spins[0] * time) * self.turned[0],
                Rotation.from_rotvec(self.spins[1] * time) * self.turned[1],
            ),
        )


def contact(pair: Pair, touch: Motion) -> tuple[Motion, float]:
    """Follow a contact from touch to parting; return the motion then, and how long it took, s."""
    masses, inertias, radii = pair.masses_kg, pair.inertias, np.array(pair.radii_m)
    reduced = 1.0 / (1.0 / masses).sum()
    stiffness = reduced * (3.21804 / pair.duration_s) ** 2.5
    tangential = 1.0 / (1.0 / masses + radii**2 / inertias).sum()
    dashpot = pair.damping * np.sqrt(5.0 * reduced * stiffness)
    x, v, w = touch.places.copy(), touch.velocities.copy(), touch.spins.copy()
    turned, spring, time = np.zeros((2, 3)), np.zeros(3), 0.0
    step = pair.duration_s / _STEPS
    while True:
        gap = x[1] - x[0]
        distance = math.sqrt(gap @ gap)
        n = gap / distance
        depth = radii.sum() - distance
        if depth < 0.0:
            break
        relative = v[1] - v[0]
        opening = float(relative @ n)
        arms = radii - 0.5 * depth
        slip = relative - opening * n - cross(arms[0] * w[0] + arms[1] * w[1], n)
        push = max(stiffness * depth**1.5 - dashpot * depth**0.25 * opening, 0.0)
        stiff = pair.stiffness_ratio * 1.5 * stiffness * math.sqrt(depth)
        spring = spring + step * slip
        spring = spring - (spring @ n) * n
        spring = _cut(spring, pair.friction * push / stiff) if stiff > 0.0 else 0.0 * spring
        damped = 2.0 * pair.tangential_damping * math.sqrt(stiff * tangential)
        drag = _cut(-stiff * spring - damped * slip, pair.friction * push)
        force = push * n + drag
        v = v + step * np.array([-force / masses[0], force / masses[1]])
        v[:, 0] += step * GRAVITY
        torque = cross(n, drag)
        # The force on a acts at + arm n of its centre and is -drag; that on b at - arm n.
        w = w - step * (arms / inertias)[:, None] * torque
        x, turned, time = x + step * v, turned + step * w, time + step
    ends = tuple(
        Rotation.from_rotvec(angle) * own for angle, own in zip(turned, touch.turned, strict=True)
    )
    return Motion(x, v, w, (ends[0], ends[1])), time


def _cut(vector: Floats, longest: float) -> Floats:
    length = math.sqrt(vector @ vector)
    return vector if length <= longest else vector * (longest / length)


def film(pair: Pair, touch: Motion, times_s: Floats) -> tuple[Floats, Floats]:
    """Return places, m, (F, 2, 3), and quaternions, scalar first, (F, 2, 4), at times from touch.

    Times of the contact show the spheres as they touched.
    """
    parted, lasted = contact(pair, touch)
    shown = [parted.later(t - lasted) if t > lasted else touch.later(min(t, 0.0)) for t in times_s]
    turns = [[own.as_quat(scalar_first=True) for own in one.turned] for one in shown]
    return np.array([one.places for one in shown]), np.array(turns)
