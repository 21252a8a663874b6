"""One sphere that is thrown onto a plate, followed through air and through every bounce.

Flights by an adaptive Runge-Kutta method with drag; contacts by small steps of all their forces.
X points down. The plate's surface goes through the origin; it lies level, leans, or is a wall.

References
----------
Cundall, Strack, Geotechnique 29 (1979) 47-65; Tsuji, Tanaka, Ishida, Powder Technology 71 (1992)
239-250; Kuwabara, Kono, Jpn. J. Appl. Phys. 26 (1987) 1230.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from simulators.world.vectors import added, crossed, dot, times, triple

Floats = NDArray[np.float64]

GRAVITY = 9.80665
AIR_DENSITY = 1.2
_CONTACT_STEPS = 4000
"""In an undamped contact."""
_AT_REST_M_PER_S = 0.1
_RELATIVE, _ABSOLUTE = 1e-10, 1e-12
"""Tolerances of a flight, m and m/s."""


@dataclass(frozen=True, slots=True)
class Drop:
    """A solid sphere, what it meets, and what acts on it.

    Parameters
    ----------
    radius_m, density_kg_per_m3
        Of the sphere; its moment of inertia is 0.4 m r^2.
    duration_s
        Of an undamped contact at 1 m/s.
    viscous
        Whether the dashpot goes with the root of the overlap (Kuwabara, Kono), or with the fourth
        root (Tsuji).
    damping
        Dimensionless damping of a contact at 2 m/s.
    friction, stiffness_ratio, tangential_damping
        mu, kt / kn, and the tangential dashpot over its critical value.
    drag_coefficient
        Of the sphere in air.
    tilt
        Lean of the plate's normal toward +Y and +Z.
    into
        The plate's normal before it leans: from the sphere into it, of any length.
    """

    radius_m: float = 0.0127
    density_kg_per_m3: float = 1150.0
    duration_s: float = 2.4e-4
    viscous: bool = False
    damping: float = 0.25
    friction: float = 0.15
    stiffness_ratio: float = 0.3
    tangential_damping: float = 0.05
    drag_coefficient: float = 0.0
    tilt: tuple[float, float] = (0.0, 0.0)
    into: tuple[float, float, float] = (1.0, 0.0, 0.0)

    @property
    def mass_kg(self) -> float:
        """Of the sphere."""
        return self.density_kg_per_m3 * 4 / 3 * np.pi * self.radius_m**3

    @property
    def normal(self) -> Floats:
        """Unit vector into the plate."""
        normal = np.array(self.into) / np.linalg.norm(self.into) + np.array([0.0, *self.tilt])
        return np.asarray(normal / np.linalg.norm(normal))

    @property
    def stiffness(self) -> float:
        """K of N = k x^(3/2), N m^-1.5: a contact lasts 3.2180 (m^2 / (k^2 v))^(1/5)."""
        return float(self.mass_kg * (3.21804 / self.duration_s) ** 2.5)

    @property
    def dashpot(self) -> float:
        """C of N = k x^(3/2) + c x^q x', SI units."""
        power = 0.5 if self.viscous else 0.25
        depth = (self.mass_kg * 4.0 / self.stiffness) ** 0.4
        return float(self.damping * self.stiffness * depth ** (1.5 - power) / 2.0)


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Where a sphere is and how it moves: (3,) in m, m/s, rad/s; its orientation."""

    place: Floats
    velocity: Floats
    spin: Floats
    turned: Rotation


def bounce(drop: Drop, met: Body) -> tuple[Body, float]:
    """Follow a contact from touch to parting; return the sphere then, and how long it took, s."""
    n, m, r = triple(drop.normal), drop.mass_kg, drop.radius_m
    k, c, power = drop.stiffness, drop.dashpot, 0.5 if drop.viscous else 0.25
    inertia, tangential = 0.4 * m * r * r, 2.0 / 7.0 * m
    place, velocity, spin = triple(met.place), triple(met.velocity), triple(met.spin)
    step = drop.duration_s * dot(velocity, n) ** -0.2 / _CONTACT_STEPS
    depth, time, spring, angle = 0.0, 0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    fall = (GRAVITY, 0.0, 0.0)
    while True:
        # Velocities half a step on, places a step on: second order, and as plain as can be.
        into = dot(velocity, n)
        depth += step * into
        if depth <= 0.0:
            break
        push = max(k * depth**1.5 + c * depth**power * into, 0.0)
        arm = times(r - depth, n)
        slip = added(added(velocity, -into, n), 1.0, crossed(spin, arm))
        stiff = drop.stiffness_ratio * 1.5 * k * math.sqrt(depth)
        spring = added(spring, step, slip)
        length = math.sqrt(dot(spring, spring))
        if stiff * length > drop.friction * push:
            spring = times(drop.friction * push / (stiff * length), spring)
        damped = 2.0 * drop.tangential_damping * math.sqrt(stiff * tangential)
        drag = added(times(-stiff, spring), -damped, slip)
        size = math.sqrt(dot(drag, drag))
        if size > drop.friction * push:
            drag = times(drop.friction * push / size, drag)
        velocity = added(velocity, step / m, added(drag, -push, n))
        velocity = added(velocity, step, fall)
        spin = added(spin, step / inertia, crossed(arm, drag))
        place, angle = added(place, step, velocity), added(angle, step, spin)
        time += step
    turned = Rotation.from_rotvec(angle) * met.turned
    return Body(np.array(place), np.array(velocity), np.array(spin), turned), time


def fly(drop: Drop, start: Body, times_s: Floats, until_s: float) -> tuple[Floats, Body, float]:
    """Follow a flight from time 0 until the sphere touches the plate, or a time has come.

    Returns
    -------
    Places at those of the times that come before, (T, 3); the sphere at the end, and when that is.
    """
    factor = drop.drag_coefficient * AIR_DENSITY * np.pi * drop.radius_m**2 / (2 * drop.mass_kg)

    def rates(_: float, y: Floats) -> Floats:
        v = y[3:]
        pull = -factor * np.linalg.norm(v) * v
        pull[0] += GRAVITY
        return np.concatenate([v, pull])

    def touch(_: float, y: Floats) -> float:
        return float(y[:3] @ drop.normal) + drop.radius_m

    touch.terminal, touch.direction = True, 1.0  # type: ignore[attr-defined]
    begin = np.concatenate([start.place, start.velocity])
    flown = solve_ivp(
        rates,
        (0.0, until_s),
        begin,
        "DOP853",
        dense_output=True,
        events=touch,
        rtol=_RELATIVE,
        atol=_ABSOLUTE,
    )
    end = float(flown.t[-1])
    own = times_s[times_s < end]
    places = np.zeros((0, 3))
    if own.size and flown.sol is not None:
        places = flown.sol(own)[:3].T
    turned = Rotation.from_rotvec(start.spin * end) * start.turned
    last = flown.y[:, -1]
    return places, Body(last[:3], last[3:], start.spin, turned), end


def film(drop: Drop, start: Body, rate_hz: float, lasts_s: float) -> tuple[Floats, Floats, Floats]:
    """Return times, s, (F,), places, m, (F, 3), and quaternions, scalar first, (F, 4), of frames.

    Frames of a contact show the sphere as it touched; there are none of one that rests.
    """
    frames, now = np.arange(0.0, lasts_s, 1.0 / rate_hz), 0.0
    places, turns = np.zeros((len(frames), 3)), np.zeros((len(frames), 4))
    done, body = 0, start
    while done < len(frames) and now < lasts_s:
        seen, met, took = fly(drop, body, frames[done:] - now, lasts_s - now)
        own = slice(done, done + len(seen))
        places[own] = seen
        spun = Rotation.from_rotvec(body.spin * (frames[own] - now)[:, None]) * body.turned
        turns[own] = np.roll(spun.as_quat(), 1, axis=1)
        done, now = own.stop, now + took
        if done >= len(frames) or met.velocity @ drop.normal < _AT_REST_M_PER_S:
            break
        body, lasted = bounce(drop, met)
        inside = np.flatnonzero((frames >= now) & (frames < now + lasted))
        places[inside], turns[inside] = met.place, np.roll(met.turned.as_quat(), 1)
        done, now = done + len(inside), now + lasted
        # Rounding must not leave the sphere inside the plate.
        lift = float(body.place @ drop.normal) + drop.radius_m
        body = replace(body, place=body.place - max(lift, 0.0) * drop.normal)
    return frames[:done], places[:done], turns[:done]
