"""Launches of the simulated rig, followed to first touch without any of the code under test.

The muzzles come from `simulators.world`; the flight is a parabola, the instant a bisection in
scalars.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Body
from analysis.launch.measurement import Touches
from analysis.launch.settings import LaunchSettings, in_turn
from analysis.launch.touch import Ground
from simulators.world.description import Sphere, Tube
from simulators.world.launch import Departure, Loaded, depart
from simulators.world.state import Motion

Floats = NDArray[np.float64]

GROUND = Ground((Body.sphere(0.0254, 1150.0, 0.4),) * 2, 9.80665)
DOWN = np.array([9.80665, 0.0, 0.0])
SIGMA = np.array([2e-3] * 6 + [0.5] * 6 + [2e-5] * 3 + [1e-3] * 2)
"""Errors of a touch as a campaign of poses has them: m/s, rad/s, m, radii of the normal."""


@dataclass(frozen=True, slots=True)
class Faults:
    """What a launch of the rig may have beside its scatter.

    hysteresis: of the speed, relative; leak: 1/s; delay_s of pusher b; rolling: spin over that of
    rolling; backlash_m of the slide.
    """

    hysteresis: float = 0.0
    leak: float = 0.0
    delay_s: float = 0.0
    rolling: float = 0.0
    backlash_m: float = 0.0


TUBE, NONE = Tube(), Faults()


@dataclass(frozen=True, slots=True)
class Drawn:
    """Settings in the order of firing: kPa of a and b, mm, s."""

    pressure_kpa: Floats
    offset_mm: Floats
    waited_s: Floats


PRESSURES_KPA = (20.0, 35.0, 50.0, 65.0, 80.0, 95.0)


def draw(shots: int, rng: np.random.Generator, pressures: tuple[float, ...]) -> Drawn:
    pressure = rng.choice(pressures, (shots, 2))
    return Drawn(pressure, rng.choice(np.arange(0.0, 20.0, 2.0), shots), rng.uniform(5, 60, shots))


def fired(
    shots: int,
    seed: int,
    faults: Faults = NONE,
    *,
    tube: Tube = TUBE,
    pressures: tuple[float, ...] = PRESSURES_KPA,
) -> tuple[Touches, LaunchSettings]:
    """Fire shots and measure their touches with Gaussian errors."""
    rng = np.random.default_rng(seed)
    drawn = draw(shots, rng, pressures)
    rows = np.array([_shot(k, drawn, faults, tube, rng) for k in range(shots)])
    touches = Touches(
        shots=np.arange(1, shots + 1),
        rows=rows + SIGMA * rng.normal(size=rows.shape),
        covariance=np.tile(np.diag(SIGMA**2), (shots, 1, 1)),
        time_s=np.full(shots, 0.0115),
        ground=GROUND,
    )
    settings = in_turn(drawn.pressure_kpa, drawn.offset_mm * 1e-3, waited_s=drawn.waited_s)
    return touches, settings


def _shot(k: int, drawn: Drawn, faults: Faults, tube: Tube, rng: np.random.Generator) -> Floats:
    offset = 1e-3 * drawn.offset_mm[k] + faults.backlash_m / 2 * _last_sign(drawn.offset_mm, k)
    ways = []
    for i, toward in enumerate((1.0, -1.0)):
        pressure = drawn.pressure_kpa[k, i] * np.exp(-faults.leak * drawn.waited_s[k])
        loaded = Loaded(tube, Sphere(), tube.height_m - toward * offset / 2, toward)
        left = depart(loaded, float(pressure), i * faults.delay_s, rng)
        assert left is not None
        factor = 1 + faults.hysteresis * _last_sign(drawn.pressure_kpa[:, i], k)
        ways.append(_with_faults(left, factor, faults.rolling))
    return _met(*ways)


def _last_sign(values: Floats, k: int) -> float:
    for j in range(k, 0, -1):
        if values[j] != values[j - 1]:
            return 1.0 if values[j] > values[j - 1] else -1.0
    return 0.0


def _with_faults(left: Departure, factor: float, rolling: float) -> tuple[float, Motion]:
    """Return when a sphere leaves and how; a push that is faster takes less time."""
    v = left.exit.velocity * factor
    spin = left.exit.spin + np.array([0.0, 0.0, -rolling * v[1] / 0.0127])
    exit_s = left.starts_s + (left.exit_s - left.starts_s) / factor
    return exit_s, Motion(left.exit.centre, v, left.exit.orientation, spin)


def _met(a: tuple[float, Motion], b: tuple[float, Motion]) -> Floats:
    """Return the touch of two spheres that leave their tubes at a time, as they do."""

    def place(way: tuple[float, Motion], time_s: float) -> Floats:
        flown = time_s - way[0]
        return np.asarray(way[1].centre + way[1].velocity * flown + DOWN * flown**2 / 2)

    apart = place(b, 0.0)[1] - place(a, 0.0)[1]
    low, high = 0.0, apart / (a[1].velocity[1] - b[1].velocity[1])
    for _ in range(60):
        half = (low + high) / 2
        far = np.linalg.norm(place(b, half) - place(a, half)) > 0.0254
        low, high = (half, high) if far else (low, half)
    first, second = place(a, high), place(b, high)
    return np.concatenate(
        [
            a[1].velocity + DOWN * (high - a[0]),
            b[1].velocity + DOWN * (high - b[0]),
            a[1].spin,
            b[1].spin,
            (first + second) / 2,
            (second - first)[[0, 2]] / 0.0254,
        ]
    )
