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

from simulators.world.vectors import Triple, added, crossed, dot, times, triple

Floats = NDArray[np.float64]

GRAVITY = 9.80665
_STEPS = 3000
"""In an undamped contact."""
NOWHERE: Triple = (0.0, 0.0, 0.0)


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
    masses, inertias = pair.masses_kg.tolist(), pair.inertias.tolist()
    first, second = pair.radii_m
    reduced = 1.0 / (1.0 / masses[0] + 1.0 / masses[1])
    stiffness = reduced * (3.21804 / pair.duration_s) ** 2.5
    mobility = [1.0 / masses[k] + pair.radii_m[k] ** 2 / inertias[k] for k in range(2)]
    tangential = 1.0 / (mobility[0] + mobility[1])
    dashpot = pair.damping * math.sqrt(5.0 * reduced * stiffness)
    x, v, w = (
        [triple(own) for own in one] for one in (touch.places, touch.velocities, touch.spins)
    )
    turned, spring, time = [NOWHERE, NOWHERE], NOWHERE, 0.0
    step = pair.duration_s / _STEPS
    fall = (GRAVITY, 0.0, 0.0)
    while True:
        gap = added(x[1], -1.0, x[0])
        distance = math.sqrt(dot(gap, gap))
        n = (gap[0] / distance, gap[1] / distance, gap[2] / distance)
        depth = first + second - distance
        if depth < 0.0:
            break
        relative = added(v[1], -1.0, v[0])
        opening = dot(relative, n)
        arms = (first - 0.5 * depth, second - 0.5 * depth)
        whirl = crossed(added(times(arms[0], w[0]), arms[1], w[1]), n)
        slip = added(added(relative, -opening, n), -1.0, whirl)
        push = max(stiffness * depth**1.5 - dashpot * depth**0.25 * opening, 0.0)
        stiff = pair.stiffness_ratio * 1.5 * stiffness * math.sqrt(depth)
        spring = added(spring, step, slip)
        spring = added(spring, -dot(spring, n), n)
        spring = _cut(spring, pair.friction * push / stiff) if stiff > 0.0 else NOWHERE
        damped = 2.0 * pair.tangential_damping * math.sqrt(stiff * tangential)
        drag = _cut(added(times(-stiff, spring), -damped, slip), pair.friction * push)
        force = added(drag, push, n)
        torque = crossed(n, drag)
        # The force on a acts at + arm n of its centre and is -drag; that on b at - arm n.
        for k, sign in enumerate((-1.0, 1.0)):
            v[k] = added(added(v[k], step * sign / masses[k], force), step, fall)
            w[k] = added(w[k], -step * (arms[k] / inertias[k]), torque)
            x[k], turned[k] = added(x[k], step, v[k]), added(turned[k], step, w[k])
        time += step
    ends = [Rotation.from_rotvec(turned[k]) * touch.turned[k] for k in range(2)]
    return Motion(np.array(x), np.array(v), np.array(w), (ends[0], ends[1])), time


def _cut(vector: Triple, longest: float) -> Triple:
    length = math.sqrt(dot(vector, vector))
    return vector if length <= longest else times(longest / length, vector)


def film(pair: Pair, touch: Motion, times_s: Floats) -> tuple[Floats, Floats]:
    """Return places, m, (F, 2, 3), and quaternions, scalar first, (F, 2, 4), at times from touch.

    Times of the contact show the spheres as they touched.
    """
    parted, lasted = contact(pair, touch)
    shown = [parted.later(t - lasted) if t > lasted else touch.later(min(t, 0.0)) for t in times_s]
    turns = [[own.as_quat(scalar_first=True) for own in one.turned] for one in shown]
    return np.array([one.places for one in shown]), np.array(turns)
