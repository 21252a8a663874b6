"""Free flight under gravity and air drag."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from simulators.world.description import Environment, Sphere
from simulators.world.rotation import turn
from simulators.world.state import Motion, Pose

Solution = Callable[[float], NDArray[np.float64]]

_RELATIVE_TOLERANCE = 1e-11
_ABSOLUTE_TOLERANCE = 1e-13


@dataclass(frozen=True, slots=True)
class Flight:
    """Spheres flying together from `start_s` on; at any time integrated over, their motions.

    `touch_s` is the instant at which the first two touch, None if they do not.
    """

    start_s: float
    touch_s: float | None
    initial: tuple[Motion, ...]
    solution: Solution

    def at(self, time_s: float) -> tuple[Motion, ...]:
        """Return the motion of each sphere; the spin is constant, as air takes none of it."""
        bodies = self.solution(time_s).reshape(-1, 2, 3)
        since = time_s - self.start_s
        return tuple(
            Motion(body[0], body[1], turn(motion.spin * since, motion.orientation), motion.spin)
            for body, motion in zip(bodies, self.initial, strict=True)
        )

    def pose(self, index: int, time_s: float) -> Pose:
        """Return the pose of one of the spheres."""
        motion = self.at(time_s)[index]
        return Pose(motion.centre, motion.orientation)


def load_integrator() -> None:
    """Load the libraries of flights, which takes most of a second; a world opens meanwhile."""
    import scipy.integrate  # noqa: F401, PLC0415


def acceleration(
    velocity: NDArray[np.float64], sphere: Sphere, environment: Environment
) -> NDArray[np.float64]:
    """Return gravity and quadratic drag, F = rho/2 c A v^2, as an acceleration (3,) in m/s^2."""
    area = math.pi * sphere.radius_m**2
    drag = 0.5 * environment.air_density_kg_per_m3 * environment.drag_coefficient * area
    speed = math.sqrt(float(velocity @ velocity))
    gravity = np.array([environment.gravity_m_per_s2, 0.0, 0.0])
    return gravity - (drag / sphere.mass_kg * speed) * velocity


def fall(
    initial: Motion,
    sphere: Sphere,
    span_s: tuple[float, float],
    plate_m: float,
    environment: Environment,
) -> Flight:
    """Integrate one sphere over a span of time, and find where it comes down on a level plate.

    `plate_m` is X of the plate's surface. A sphere that begins on the plate must be rising.
    """
    # Loaded with the first flight.
    from scipy.optimize import brentq  # noqa: PLC0415

    flight = fly([initial], [sphere], *span_s, environment)

    def gap(time_s: float) -> float:
        return plate_m - sphere.radius_m - float(flight.solution(time_s)[0])

    # It is highest after v/g at the latest; from there on the gap only shrinks.
    highest_s = span_s[0] + max(-float(initial.velocity[0]), 0.0) / environment.gravity_m_per_s2
    if highest_s >= span_s[1] or gap(span_s[1]) > 0.0:
        return flight
    touch_s = float(brentq(gap, highest_s, span_s[1], xtol=1e-13, rtol=1e-13))
    return replace(flight, touch_s=touch_s)


def fly(
    initial: Sequence[Motion],
    spheres: Sequence[Sphere],
    start_s: float,
    end_s: float,
    environment: Environment,
) -> Flight:
    """Integrate one or two spheres from `start_s` to `end_s`, and find where two first touch.

    Two spheres that overlap at the start are not taken to touch.
    """
    # Loaded by `load_integrator`, or else by the first flight.
    from scipy.integrate import solve_ivp  # noqa: PLC0415

    def derivative(_: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        rates = np.empty((len(spheres), 2, 3))
        for rate, body, sphere in zip(rates, state.reshape(-1, 2, 3), spheres, strict=True):
            rate[0] = body[1]
            rate[1] = acceleration(body[1], sphere, environment)
        return rates.ravel()

    def approach(_: float, state: NDArray[np.float64]) -> float:
        a, b = state.reshape(2, 2, 3)
        return float((b[0] - a[0]) @ (b[1] - a[1]))

    state = np.concatenate([[m.centre, m.velocity] for m in initial]).ravel()
    pair = len(spheres) == 2
    result = solve_ivp(
        derivative,
        (start_s, end_s),
        state,
        method="DOP853",
        rtol=_RELATIVE_TOLERANCE,
        atol=_ABSOLUTE_TOLERANCE,
        dense_output=True,
        events=approach if pair else None,
    )
    solution = cast("Solution", result.sol)
    touch_s = None
    if pair and result.t_events is not None:
        touch_s = _touch(solution, start_s, result.t_events[0], spheres)
    return Flight(start_s, touch_s, tuple(initial), solution)


def _touch(
    solution: Solution,
    start_s: float,
    closest: NDArray[np.float64],
    spheres: Sequence[Sphere],
) -> float | None:
    """Return when the gap first closes, given the instants of closest approach."""
    # Loaded with the first flight.
    from scipy.optimize import brentq  # noqa: PLC0415

    reach = spheres[0].radius_m + spheres[1].radius_m

    def gap(time_s: float) -> float:
        a, b = solution(time_s).reshape(2, 2, 3)
        return float(np.linalg.norm(b[0] - a[0])) - reach

    # The gap falls steadily until the closest approach: a sign change there brackets one root,
    # and a graze shorter than a step of the integration is not missed.
    if gap(start_s) <= 0.0:
        return None
    for time_s in closest:
        if gap(float(time_s)) < 0.0:
            return float(brentq(gap, start_s, float(time_s), xtol=1e-13, rtol=1e-13))
    return None
