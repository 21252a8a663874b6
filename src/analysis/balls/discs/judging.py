"""Whether a candidate is a disc: a circle through its edge points, and its number of false alarms.

A contrario (Desolneux, Moisan and Morel, 2000): how many discs of such a kind would a picture of
the same size show whose gradients point anywhere?
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part

SECTORS = 64
LEAST_SECTORS = 0.42
TOLERANCES = np.radians([22.5, 11.0, 6.0])
"""Of a rim sample's direction against the radius: a ragged rim needs a wide one, and few samples of
a sharp one, partly hidden, say more with a narrow one."""
_ALONG = np.cos(TOLERANCES)
_CHANCES = TOLERANCES / (0.5 * math.pi)
"""Of a direction that near to the radius, towards it or away, by chance."""
LEAST_OF_EDGES = 0.5
"""Of an edge's least size: weaker gradients have no direction that counts."""
SAMPLE_PX = 1.5
PASSES = ((0.10, 29.0), (0.07, 26.0), (0.05, 23.0), (0.03, 20.0))
"""Distance from the circle in radii, and angle with the radius in degrees, from pass to pass."""
_BANDS = np.array([[band, math.cos(math.radians(angle))] for band, angle in PASSES])
LEAST_BAND_PX = 0.8
SQUARE_RADII = 1.2
"""Half of the side of a square whose edges are looked through while the circle stays in it."""
LEAST_POINTS = 8


@part
def _solve(matrix: NDArray[np.float64], right: NDArray[np.float64]) -> bool:
    """Solve three equations in place by elimination; false where they are singular."""
    for i in range(3):
        best = i
        for k in range(i + 1, 3):
            if abs(matrix[k, i]) > abs(matrix[best, i]):
                best = k
        if abs(matrix[best, i]) < 1e-9:
            return False
        for j in range(3):
            matrix[i, j], matrix[best, j] = matrix[best, j], matrix[i, j]
        right[i], right[best] = right[best], right[i]
        for k in range(3):
            if k != i:
                ratio = matrix[k, i] / matrix[i, i]
                for j in range(3):
                    matrix[k, j] -= ratio * matrix[i, j]
                right[k] -= ratio * right[i]
    for i in range(3):
        right[i] /= matrix[i, i]
    return True


@compiled
def log_binomial_tail(samples: int, hits: int, chance: float) -> float:
    """Return log10 of the probability of so many hits or more."""
    total = 0.0
    largest = -1e300
    for k in range(hits, samples + 1):
        term = (
            math.lgamma(samples + 1.0)
            - math.lgamma(k + 1.0)
            - math.lgamma(samples - k + 1.0)
            + k * math.log(chance)
            + (samples - k) * math.log(1.0 - chance)
        )
        if largest < -1e299:
            largest = term
        total += math.exp(term - largest)
    return (largest + math.log(total)) / math.log(10.0) if hits <= samples else -1e9


@part
def _first_in_row(edges: NDArray[np.float32], row: float) -> int:
    """Return before which edge all lie above a row."""
    low, high = 0, len(edges)
    while low < high:
        middle = (low + high) // 2
        if edges[middle, 0] < row:
            low = middle + 1
        else:
            high = middle
    return low


@part
def _about(
    edges: NDArray[np.float32], weights: NDArray[np.float32], square: NDArray[np.float64]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the edges with a weight in a square (row, column, half of a side), and weights.

    Edges come row by row, half a pixel off at most, so that most of them need no look.
    """
    first = _first_in_row(edges, square[0] - square[2] - 1.0)
    last = _first_in_row(edges, square[0] + square[2] + 2.0)
    own = np.empty((last - first, edges.shape[1]), np.float32)
    own_weights, count = np.empty(last - first, np.float32), 0
    for k in range(first, last):
        if weights[k] <= 0.0 or abs(edges[k, 0] - square[0]) > square[2]:
            continue
        if abs(edges[k, 1] - square[1]) <= square[2]:
            own[count], own_weights[count] = edges[k], weights[k]
            count += 1
    return own[:count], own_weights[:count]


@part
def _gather(
    edges: NDArray[np.float32],
    weights: NDArray[np.float32],
    circle: NDArray[np.float64],
    limits: NDArray[np.float64],
    sums: NDArray[np.float64],
) -> None:
    """Sum the normal equations of the points in a band; Tukey's biweight times their own weights.

    Parameters
    ----------
    weights
        Of the points.
    limits
        Width of the band in px and least cosine of a point's angle with the radius.
    sums
        Filled: matrix and right side in the first three rows; then weights, squares, points.
    """
    row, column, radius = circle
    band, along = limits
    sums[:] = 0.0
    for k in range(len(edges)):
        dr, dc = edges[k, 0] - row, edges[k, 1] - column
        if abs(dr) > radius + band or abs(dc) > radius + band:
            continue
        away = math.sqrt(dr * dr + dc * dc)
        off = away - radius
        if abs(off) > band or away < 1e-6:
            continue
        u, v = dr / away, dc / away
        if abs(u * edges[k, 2] + v * edges[k, 3]) < along:
            continue
        share = off / band
        weight = weights[k] * (1.0 - share * share) ** 2
        slopes = (u, v, 1.0)
        for i in range(3):
            for j in range(3):
                sums[i, j] += weight * slopes[i] * slopes[j]
            sums[i, 3] += weight * slopes[i] * off
        sums[3, 0] += weight
        sums[3, 1] += weight * off * off
        sums[3, 2] += 1.0


@compiled
def sectors(
    edges: NDArray[np.float32],
    weights: NDArray[np.float32],
    circle: NDArray[np.float64],
    limits: NDArray[np.float64],
) -> float:
    """Return the share of the sectors of a circle that hold points of its rim."""
    filled = np.zeros(SECTORS, np.bool_)
    for k in range(len(edges)):
        if weights[k] <= 0.0:
            continue
        dr, dc = edges[k, 0] - circle[0], edges[k, 1] - circle[1]
        away = math.sqrt(dr * dr + dc * dc)
        if abs(away - circle[2]) > limits[0] or away < 1e-6:
            continue
        if abs(dr * edges[k, 2] + dc * edges[k, 3]) >= limits[1] * away:
            turn = (math.atan2(dr, dc) + math.pi) / (2.0 * math.pi)
            filled[int(turn * SECTORS) % SECTORS] = True
    return float(filled.sum() / SECTORS)


@compiled
def fit_circle(
    edges: NDArray[np.float32],
    weights: NDArray[np.float32],
    start: NDArray[np.float64],
    bands: int,
) -> NDArray[np.float64]:
    """Fit a circle to the edge points near a candidate, in a band that narrows from pass to pass.

    Parameters
    ----------
    edges
        Row by row, or half a pixel off such an order.
    weights
        Of the edges, at most 1; 0 leaves one out.
    start
        Row, column, radius.
    bands
        How many of the bands are gone through, the widest first.

    Returns
    -------
    Row, column, radius, their standard errors, and the share of the sectors with points; all zero
    where none is found. Shape (7,).
    """
    found = np.zeros(7)
    circle = start.copy()
    sums, limits = np.zeros((4, 4)), np.zeros(2)
    square = np.zeros(3)
    own, own_weights = edges, weights
    matrix, right = np.zeros((3, 3)), np.zeros(3)
    for step in range(2 * bands):
        limits[0] = max(LEAST_BAND_PX, _BANDS[step // 2, 0] * circle[2])
        limits[1] = _BANDS[step // 2, 1]
        reach = circle[2] + limits[0]
        moved = max(abs(circle[0] - square[0]), abs(circle[1] - square[1]))
        if moved + reach > square[2]:
            square[:2], square[2] = circle[:2], SQUARE_RADII * reach
            own, own_weights = _about(edges, weights, square)
        _gather(own, own_weights, circle, limits, sums)
        matrix[:] = sums[:3, :3]
        right[:] = sums[:3, 3]
        if sums[3, 2] < LEAST_POINTS or not _solve(matrix, right):
            return found
        circle += right
        if not (0.6 * start[2] < circle[2] < 1.6 * start[2]):
            return found
    scatter = math.sqrt(sums[3, 1] / sums[3, 0])
    for i in range(3):
        matrix[:] = sums[:3, :3]
        right[:] = 0.0
        right[i] = 1.0
        if not _solve(matrix, right):
            return found
        found[3 + i] = scatter * math.sqrt(max(right[i], 0.0))
    found[:3] = circle
    square[:2], square[2] = circle[:2], circle[2] + limits[0]
    own, own_weights = _about(edges, weights, square)
    found[6] = sectors(own, own_weights, circle, limits)
    return found


@compiled
def false_alarms(
    field: NDArray[np.float32],
    threshold: float,
    circle: NDArray[np.float64],
    log_tests: float,
) -> NDArray[np.float64]:
    """Return log10 of a circle's false alarms, the share of its rim seen, and of it clear.

    Samples of the rim outside the picture, and those that are not clear, as the rim of a surer disc
    is there (a negative size), count neither way.

    Parameters
    ----------
    field
        Size and direction (row, column) of the gradient, shape (3, rows, columns).
    """
    _, rows, columns = field.shape
    row, column, radius = circle
    wanted = max(12, int(2.0 * math.pi * radius / SAMPLE_PX))
    shown = samples = 0
    hits = np.zeros(len(_ALONG), np.int64)
    for k in range(wanted):
        angle = 2.0 * math.pi * k / wanted
        u, v = math.sin(angle), math.cos(angle)
        i, j = round(row + radius * u), round(column + radius * v)
        if i < 0 or j < 0 or i >= rows or j >= columns:
            continue
        shown += 1
        if field[0, i, j] < 0.0:
            continue
        samples += 1
        if field[0, i, j] < LEAST_OF_EDGES * threshold:
            continue
        along = abs(u * field[1, i, j] + v * field[2, i, j])
        for m in range(len(_ALONG)):
            if along >= _ALONG[m]:
                hits[m] += 1
    found = np.zeros(3)
    found[0] = log_tests
    found[2] = samples / max(shown, 1)
    if samples >= LEAST_POINTS:
        best = 0.0
        for m in range(len(_ALONG)):
            best = min(best, log_binomial_tail(samples, hits[m], _CHANCES[m]))
        # Each tolerance is a test of its own.
        found[0] += best + math.log10(len(_ALONG))
        found[1] = hits[0] / wanted
    return found
