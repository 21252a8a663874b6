"""The shapes that a dependence may have, each with the constants that give it its scale.

A shape turns numbers x into columns f(x), and a coefficient becomes c0 [1 + a f(x)]; a power
becomes c0 (x / x0)^p, to first order the column ln(x / x0).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats

STEP_WIDTH = 0.01
"""Of a step, as a share of the argument's range: a step without one has no slope to fit by."""


@dataclass(frozen=True, slots=True)
class Spread:
    """Where shots lie in one argument: 1 and 99 per cent of them, and their mean."""

    low: float
    high: float
    mean: float

    @property
    def range(self) -> float:
        """Width, in the argument's unit."""
        return self.high - self.low


def spread_of(values: Floats) -> Spread:
    """Return where values (S,) lie."""
    low, high = np.quantile(values, [0.01, 0.99])
    return Spread(float(low), float(high), float(values.mean()))


@dataclass(frozen=True, slots=True)
class Shape:
    """One shape.

    Attributes
    ----------
    name
        As documents have it.
    fixed, free
        Names of its constants: those that only set a zero, and those that a fit determines.
    columns
        From x (S,) and constants, fixed before free, to columns (S, amplitudes).
    codes
        The same as expressions in x and the constants' names.
    grid
        Constants that are tried, for a spread of shots.
    dimension
        Power of the argument's unit that the columns have.
    """

    name: str
    fixed: tuple[str, ...]
    free: tuple[str, ...]
    columns: Callable[[Floats, tuple[float, ...]], Floats]
    codes: tuple[str, ...]
    grid: Callable[[Spread, int], list[tuple[float, ...]]]
    dimension: int = 0

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of all constants."""
        return (*self.fixed, *self.free)


def _one(values: Floats) -> Floats:
    return np.asarray(values[:, None])


def _within(spread: Spread, shares: Floats) -> Floats:
    return spread.low + spread.range * shares


def _centres(spread: Spread, fine: int) -> Floats:
    """Return where bumps are tried; finely near the ends too, where half of one is seen."""
    if fine == 1:
        return _within(spread, np.linspace(0.12, 0.88, 4))
    return _within(spread, np.linspace(0.02, 0.98, 6 * fine))


LINEAR = Shape(
    "linear",
    ("x0",),
    (),
    lambda x, c: _one(x - c[0]),
    ("x - x0",),
    lambda spread, fine: [(spread.mean,)],
    1,
)
POWER = Shape(
    "power",
    ("x0",),
    (),
    lambda x, c: _one(np.log(np.maximum(x, 1e-9) / c[0])),
    ("np.log(np.maximum(x, 1e-9) / x0)",),
    lambda spread, fine: [(max(spread.mean, 1e-9),)],
)
SQUARE = Shape(
    "power",
    ("x0",),
    (),
    lambda x, c: _one((x - c[0]) ** 2),
    ("(x - x0) ** 2",),
    lambda spread, fine: [(spread.mean,)],
    2,
)
EXPONENTIAL = Shape(
    "exponential",
    ("x0",),
    ("c",),
    lambda x, c: _one(np.exp(-(x - c[0]) / c[1])),
    ("np.exp(-(x - x0) / c)",),
    lambda spread, fine: [
        (spread.low, float(spread.range * share))
        for share in np.geomspace(0.1, 0.8, 2 if fine == 1 else 8 * fine)
    ],
)
SIZE_EXPONENTIAL = Shape(
    "exponential",
    (),
    ("c",),
    lambda x, c: _one(np.exp(-x / c[0])),
    ("np.exp(-x / c)",),
    lambda spread, fine: [
        (float(spread.high * share),)
        for share in np.geomspace(0.08, 0.8, 3 if fine == 1 else 8 * fine)
    ],
)
HINGE = Shape(
    "hinge",
    (),
    ("h",),
    lambda x, c: _one(np.maximum(x - c[0], 0.0)),
    ("np.maximum(x - h, 0.0)",),
    lambda spread, fine: [
        (float(place),) for place in _within(spread, np.linspace(0.2, 0.75, 2 if fine == 1 else 30))
    ],
    1,
)
STEP = Shape(
    "step",
    ("w",),
    ("s",),
    lambda x, c: _one(0.5 * (1.0 + np.tanh((x - c[1]) / c[0]))),
    ("0.5 * (1.0 + np.tanh((x - s) / w))",),
    lambda spread, fine: [
        (STEP_WIDTH * spread.range, float(place))
        for place in _within(spread, np.linspace(0.1, 0.9, 5 if fine == 1 else 41))
    ],
)
BUMP = Shape(
    "bump",
    (),
    ("m", "w"),
    lambda x, c: _one(np.exp(-0.5 * ((x - c[0]) / c[1]) ** 2)),
    ("np.exp(-0.5 * ((x - m) / w) ** 2)",),
    lambda spread, fine: [
        (float(centre), float(width * spread.range))
        for width in ((0.12,) if fine == 1 else (0.05, 0.08, 0.12, 0.18, 0.27))
        for centre in _centres(spread, fine)
    ],
)
PERIODIC = Shape(
    "periodic",
    ("x0",),
    ("P",),
    lambda x, c: np.stack(
        [np.sin(2 * np.pi * (x - c[0]) / c[1]), np.cos(2 * np.pi * (x - c[0]) / c[1])], axis=1
    ),
    ("np.sin(2 * np.pi * (x - x0) / P)", "np.cos(2 * np.pi * (x - x0) / P)"),
    lambda spread, fine: [
        (spread.mean, float(spread.range / waves))
        for waves in ((1.5, 3.0, 4.5) if fine == 1 else np.linspace(1.25, 5.0, 31))
    ],
)

FOR_SPEEDS = (LINEAR, POWER, SIZE_EXPONENTIAL, HINGE, STEP, BUMP)
FOR_SIZES = (LINEAR, SIZE_EXPONENTIAL, HINGE, STEP, BUMP)
FOR_SIGNED = (LINEAR, SQUARE)
FOR_COLUMNS = (LINEAR, SQUARE, EXPONENTIAL, HINGE, STEP, BUMP, PERIODIC)
FOR_PLACES = (LINEAR, SQUARE, HINGE, STEP, BUMP, PERIODIC)
SHAPES = (
    *(LINEAR, POWER, SQUARE, EXPONENTIAL, SIZE_EXPONENTIAL),
    *(HINGE, STEP, BUMP, PERIODIC),
)
