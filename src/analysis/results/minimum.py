"""The minimum of a smooth function of a few numbers, and its curvature there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from analysis.arrays import Floats

STEP = 0.01
"""Of the derivatives, in the units of the numbers."""
ROUNDS, HALVINGS = 60, 12
SETTLED = 1e-8
LEAST_CURVATURE = 1e-9
"""Of the largest: a flatter direction is not followed."""


def minimum(cost: Callable[[Floats], float], size: int) -> tuple[Floats, Floats]:
    """Search from zero by Newton's method, derivatives by central differences.

    Parameters
    ----------
    cost
        Its numbers in units in which its curvature is of the order of one.
    size
        How many numbers it has.

    Returns
    -------
    Where the search comes to rest, shape (size,), and the second derivatives there, (size, size).
    """
    place = np.zeros(size)
    here = cost(place)
    for _ in range(ROUNDS):
        slope, curvature = _derivatives(cost, place, here)
        values, vectors = np.linalg.eigh(curvature)
        steep = np.maximum(np.abs(values), LEAST_CURVATURE * max(np.abs(values).max(), 1e-300))
        step = -vectors @ ((vectors.T @ slope) / steep)
        there = here
        for _ in range(HALVINGS):
            there = cost(place + step)
            if there <= here:
                break
            step = step / 2
        if not there <= here:
            break
        place, fall, here = place + step, here - there, there
        if fall <= SETTLED:
            break
    return place, _derivatives(cost, place, here)[1]


def _derivatives(
    cost: Callable[[Floats], float], place: Floats, here: float
) -> tuple[Floats, Floats]:
    """Return slope and curvature."""
    size = len(place)
    axes = STEP * np.eye(size)
    up, down = (np.array([cost(place + sign * axis) for axis in axes]) for sign in (1, -1))
    slope = (up - down) / (2 * STEP)
    curvature = np.diag(up + down - 2 * here)
    for i in range(size):
        for j in range(i):
            mixed = cost(place + axes[i] + axes[j]) + cost(place - axes[i] - axes[j])
            mixed += 2 * here - up[i] - down[i] - up[j] - down[j]
            curvature[i, j] = curvature[j, i] = mixed / 2
    return slope, curvature / STEP**2
