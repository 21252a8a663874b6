"""What a picture shows along the radii of a circle: colours at both sides, changes, the inside."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.balls.discs.judging import SECTORS
from analysis.compiled import compiled, part

RING_PX, RING = (1.5, 3.5), (0.06, 0.18)
"""Where inside and outside of a rim are looked at: from and to, off the circle, in pixels at least
and in radii."""
DEPTHS, LEAST_DEPTH = 4, 0.4
"""At how many distances, and not nearer to the centre than this, in radii."""
REACH_PX, REACH, STEP_PX = 3.0, 0.2, 0.25
"""How far off the circle its strongest change is looked for, in pixels at least and in radii, and
in which steps."""
DEEP, LAYERS = 0.85, 8
"""How far from the centre all of the inside is looked at, in radii, and at how many distances, each
for as much of its area."""
CORE, CORES = 0.45, 4
"""How far from the centre its colours are looked at, in radii, and at how many distances."""


@compiled
def rim_of(
    window: NDArray[np.float32],
    down: NDArray[np.float32],
    right: NDArray[np.float32],
    circle: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Return what each sector of a circle shows along its radius.

    Returns
    -------
    Colours inside and outside of the rim, shape (SECTORS, channels) each; how far off the circle
    the strongest change lies, its share along the radius and its size, shape (3, SECTORS); and
    whether all of this is in the window, shape (SECTORS,).
    """
    channels = window.shape[2]
    inside, outside = np.zeros((SECTORS, channels)), np.zeros((SECTORS, channels))
    changes = np.zeros((3, SECTORS))
    shown = np.ones(SECTORS, np.bool_)
    radius = circle[2]
    near, far = max(RING_PX[0], RING[0] * radius), max(RING_PX[1], RING[1] * radius)
    deep = max(radius - far, LEAST_DEPTH * radius)
    reach = max(REACH_PX, REACH * radius)
    for k in range(SECTORS):
        u, v = math.sin(2.0 * math.pi * k / SECTORS), math.cos(2.0 * math.pi * k / SECTORS)
        for m in range(DEPTHS):
            share = m / (DEPTHS - 1)
            for side in range(2):
                away = radius + near + share * (far - near)
                if side == 0:
                    away = deep + share * (radius - near - deep)
                row, column = circle[0] + away * u, circle[1] + away * v
                if not _within(window, row, column):
                    shown[k] = False
                    continue
                for c in range(channels):
                    value = _between(window, row, column, c) / DEPTHS
                    if side == 0:
                        inside[k, c] += value
                    else:
                        outside[k, c] += value
        for m in range(int(2.0 * reach / STEP_PX) + 1):
            off = m * STEP_PX - reach
            row, column = circle[0] + (radius + off) * u, circle[1] + (radius + off) * v
            if not _within(window, row, column):
                continue
            steep = across = 0.0
            for c in range(channels):
                p, q = _between(down, row, column, c), _between(right, row, column, c)
                steep += (u * p + v * q) ** 2
                across += (v * p - u * q) ** 2
            if steep > changes[2, k] ** 2:
                changes[0, k] = off
                changes[1, k] = math.sqrt(steep / (steep + across))
                changes[2, k] = math.sqrt(steep)
    return inside, outside, changes, shown


@part
def _within(values: NDArray[np.float32], row: float, column: float) -> bool:
    rows, columns, _ = values.shape
    return row >= 0.0 and column >= 0.0 and row <= rows - 1.001 and column <= columns - 1.001


@part
def _between(values: NDArray[np.float32], row: float, column: float, channel: int) -> float:
    """Return a value between pixels."""
    i, j = int(row), int(column)
    p, q = row - i, column - j
    above = (1.0 - q) * values[i, j, channel] + q * values[i, j + 1, channel]
    below = (1.0 - q) * values[i + 1, j, channel] + q * values[i + 1, j + 1, channel]
    return float((1.0 - p) * above + p * below)


@compiled
def middle_of(window: NDArray[np.float32], circle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return colours about a circle's centre that are in the window, shape (N, channels)."""
    channels = window.shape[2]
    colours, count = np.zeros((CORES * SECTORS, channels)), 0
    for k in range(SECTORS):
        u, v = math.sin(2.0 * math.pi * k / SECTORS), math.cos(2.0 * math.pi * k / SECTORS)
        for step in range(CORES):
            away = CORE * circle[2] * step / (CORES - 1)
            row, column = circle[0] + away * u, circle[1] + away * v
            if _within(window, row, column):
                for c in range(channels):
                    colours[count, c] = _between(window, row, column, c)
                count += 1
    return colours[:count]


@compiled
def through(
    window: NDArray[np.float32],
    circle: NDArray[np.float64],
    outside: NDArray[np.float64],
    ground: NDArray[np.float64],
    near: float,
) -> float:
    """Return the share of a circle's inside whose colour is that of what is outside.

    Parameters
    ----------
    outside, ground
        Colours outside of each sector, shape (SECTORS, channels), and of all, shape (channels,).
    near
        How far a colour may be off.
    """
    seen = same = 0
    for k in range(SECTORS):
        u, v = math.sin(2.0 * math.pi * k / SECTORS), math.cos(2.0 * math.pi * k / SECTORS)
        for m in range(LAYERS):
            away = DEEP * circle[2] * math.sqrt((m + 0.5) / LAYERS)
            row, column = circle[0] + away * u, circle[1] + away * v
            if not _within(window, row, column):
                continue
            seen += 1
            here = all_over = 0.0
            for c in range(window.shape[2]):
                value = _between(window, row, column, c)
                here += (value - outside[k, c]) ** 2
                all_over += (value - ground[c]) ** 2
            same += min(here, all_over) < near * near
    return same / max(seen, 1)
