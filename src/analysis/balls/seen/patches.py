"""The place of a ball with patches, by its outline: what its surface shows is free in each frame.

A ball with a pattern that turns shows other patches in each frame; one at the rim that is as light
as the ground looks like ground. Light of a pixel: F = B (1 - a) + a (S + P), with ground B, cover a
and smooth shading S as in `photometry`, and patches P: one number a pixel, which differ little from
one pixel to the next, or much where a patch ends. An outline that is too small leaves light of the
ball that nothing explains. One that is too large takes ground for a patch, whose edge along the rim
costs as much as it is long. So an outline has a place wherever the ball differs from its ground.

The least of sum w (F - model)^2 + RIGID EDGE^2 sum log(1 + (step of P / EDGE)^2), steps between
neighbours (Student's t of one degree of freedom), is sought by Gauss-Newton steps with weights set
anew; P is eliminated in each by a Cholesky factor of bands (George & Liu, 1981, chapter 4).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.balls.seen.photometry import (
    BLUR,
    GROUND,
    LARGEST_STEP_PX,
    LAYERS,
    LEAST_COVER,
    MAP_SIDE,
    RADIUS,
    RESIDUAL,
    STRETCH,
    TERMS,
    UNKNOWNS,
    WEIGHT,
    cover,
    rim,
)
from analysis.compiled import compiled, part

RIGID, EDGE = 0.3, 0.07
"""Weight of a step between neighbouring pixels' patches over that of a pixel's light, and the step
from which it counts less; in the ball's contrast to its ground."""
SHADE = 0.1
"""A pixel beside the ball that is darker than the ground by more counts less: shadows."""
CHANCE, ALIKE = 0.04, 0.05
"""What it costs that a pixel of the ball is as light as the ground behind it, or its shadow, by
chance, and how far light may differ that is alike."""
BAND_PX, BAND_BLURS = 3.0, 5.0
"""Within the rim: what lies further in says nothing of a place."""
FREE = 1e-6
"""Weight of a patch by itself over that of a step, which keeps the matrix regular."""
PASSES, LEAST_PASSES, SETTLED_PX = 12, 4, 2e-3
LEFT = 7
"""Where the fit has what it leaves in the whole window."""


@part
def _number(
    shown: NDArray[np.float64], pose: NDArray[np.float64], numbers: NDArray[np.int64]
) -> tuple[int, int]:
    """Count pixels near the rim that the ball covers, by rows; return how many, and the band."""
    _, rows, columns = shown.shape
    within = BAND_PX + BAND_BLURS * pose[BLUR]
    count, band = 0, 1
    numbers[:] = -1
    for i in range(rows):
        for j in range(columns):
            away = math.sqrt(((i - pose[0]) / pose[STRETCH]) ** 2 + (j - pose[1]) ** 2)
            if shown[0, i, j] <= LEAST_COVER or pose[RADIUS] - away > within:
                continue
            numbers[i, j] = count
            if i > 0 and numbers[i - 1, j] >= 0:
                band = max(band, count - numbers[i - 1, j])
            count += 1
    return count, band


@part
def _look(
    window: NDArray[np.float64],
    known: tuple[
        NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]
    ],
    numbers: NDArray[np.int64],
    chance: float,
    found: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
) -> float:
    """Fill in how each pixel's light changes; return the weighted squares of what is left.

    Parameters
    ----------
    known
        `cover`, its slopes by row and column, the patches, and light of the terms of the shading.
    found
        By each unknown and, last, light less model, shape (N, UNKNOWNS + 1); cover and weight of
        each pixel, shape (N, 2); by how much pixels that are as light as the ground push, (2,).
    """
    shown, moving, patches, light = known
    slopes, own, push = found
    _, rows, columns = window.shape
    left = 0.0
    push[:] = 0.0
    for i in range(rows):
        for j in range(columns):
            k, a, ground = numbers[i, j], shown[0, i, j], window[GROUND, i, j]
            off = window[0, i, j] - ground * (1.0 - a)
            change = window[0, i, j] - ground
            alike = math.exp(-0.5 * (change / (SHADE if change < 0.0 else ALIKE)) ** 2)
            alike *= chance * window[WEIGHT, i, j]
            left += a * alike
            push[0] -= 0.5 * alike * moving[0, i, j]
            push[1] -= 0.5 * alike * moving[1, i, j]
            if k < 0:
                # Far within the rim patches explain all.
                off = off if a <= LEAST_COVER else 0.0
            else:
                ball = patches[i, j]
                off -= a * ball
                for m in range(TERMS):
                    slopes[k, 2 + m] = shown[m, i, j]
                    off -= light[m] * shown[m, i, j]
                    ball += light[m] * shown[m, i, j] / a
                slopes[k, 0] = (ball - ground) * moving[0, i, j]
                slopes[k, 1] = (ball - ground) * moving[1, i, j]
                slopes[k, UNKNOWNS] = off
            window[RESIDUAL, i, j] = off
            weight, square = window[WEIGHT, i, j], off * off
            if off < 0.0 and a < 0.5:
                darker = 1.0 + square / SHADE**2
                left += weight * SHADE**2 * math.log(darker)
                weight /= darker
            else:
                left += weight * square
            if k >= 0:
                own[k, 0], own[k, 1] = a, weight
    return left


@part
def _bind(
    patches: NDArray[np.float64],
    numbers: NDArray[np.int64],
    matrix: NDArray[np.float64],
    right: NDArray[np.float64],
) -> float:
    """Add what steps between neighbours cost to the patches' equations; return the whole cost."""
    rows, columns = patches.shape
    band = matrix.shape[1] - 1
    cost = 0.0
    for i in range(rows):
        for j in range(columns):
            k = numbers[i, j]
            if k < 0:
                continue
            matrix[k, band] += FREE * RIGID
            right[k, UNKNOWNS] -= FREE * RIGID * patches[i, j]
            for down in range(2):
                p, q = i + down, j + 1 - down
                if p >= rows or q >= columns or numbers[p, q] < 0:
                    continue
                n, step = numbers[p, q], patches[p, q] - patches[i, j]
                large = 1.0 + (step / EDGE) ** 2
                weight = RIGID / large
                cost += RIGID * EDGE**2 * math.log(large)
                matrix[k, band] += weight
                matrix[n, band] += weight
                matrix[n, band - (n - k)] -= weight
                right[k, UNKNOWNS] += weight * step
                right[n, UNKNOWNS] -= weight * step
    return cost


@part
def _factor(matrix: NDArray[np.float64]) -> None:
    """Replace a symmetric matrix by its Cholesky factor; the diagonal is the last column."""
    band = matrix.shape[1] - 1
    for i in range(len(matrix)):
        first = max(0, i - band)
        for j in range(first, i + 1):
            total = matrix[i, band - (i - j)]
            for k in range(max(first, j - band), j):
                total -= matrix[i, band - (i - k)] * matrix[j, band - (j - k)]
            if j < i:
                matrix[i, band - (i - j)] = total / matrix[j, band]
            else:
                matrix[i, band] = math.sqrt(max(total, 1e-30))


@part
def _solve(factor: NDArray[np.float64], right: NDArray[np.float64]) -> None:
    """Replace right sides, shape (N, K), by the solutions."""
    band, (count, sides) = factor.shape[1] - 1, right.shape
    for i in range(count):
        for k in range(max(0, i - band), i):
            share = factor[i, band - (i - k)]
            for s in range(sides):
                right[i, s] -= share * right[k, s]
        for s in range(sides):
            right[i, s] /= factor[i, band]
    for i in range(count - 1, -1, -1):
        for s in range(sides):
            right[i, s] /= factor[i, band]
        for k in range(max(0, i - band), i):
            share = factor[i, band - (i - k)]
            for s in range(sides):
                right[k, s] -= share * right[i, s]


@part
def _reduce(
    slopes: NDArray[np.float64],
    weights: NDArray[np.float64],
    right: NDArray[np.float64],
    solved: NDArray[np.float64],
    sums: NDArray[np.float64],
) -> None:
    """Fill in the normal equations of place and shading without the patches."""
    sums[:] = 0.0
    for k in range(len(slopes)):
        for m in range(UNKNOWNS):
            for n in range(UNKNOWNS + 1):
                sums[m, n] += weights[k, 1] * slopes[k, m] * slopes[k, n]
                sums[m, n] -= right[k, m] * solved[k, n]
    for m in range(UNKNOWNS):
        sums[m, m] += 1e-9 * (1.0 + sums[m, m])


@compiled
def fit_outline(
    window: NDArray[np.float64], start: NDArray[np.float64], chance: float = CHANCE
) -> NDArray[np.float64]:
    """Fit the place of a ball whose surface may show anything.

    Parameters
    ----------
    window, start
        As `fit_place` has them; light must not fall where the ball is brighter.
    chance
        What it costs that a pixel of the ball is as light as the ground.

    Returns
    -------
    What `fit_place` returns, and the sum that is least; shape (LEFT + 1,).
    """
    _, rows, columns = window.shape
    shown, moving = np.empty((LAYERS, rows, columns)), np.zeros((2, rows, columns))
    patches, numbers = np.zeros((rows, columns)), np.empty((rows, columns), np.int64)
    plain, dark = np.zeros((MAP_SIDE, MAP_SIDE)), np.full((rows, columns), -1.0)
    pose, light, none = start.copy(), np.zeros(TERMS), np.zeros(TERMS)
    sums, found = np.zeros((UNKNOWNS, UNKNOWNS + 1)), np.zeros(LEFT + 1)
    count, cost, push = 0, 0.0, np.zeros(2)
    for passing in range(PASSES):
        cover(pose, plain, shown)
        # Of a ball of no light before a ground of -1 the change is that of its cover.
        rim(pose, none, plain, dark, moving)
        count, band = _number(shown, pose, numbers)
        if count < 3 * UNKNOWNS:
            return found
        slopes, own = np.zeros((count, UNKNOWNS + 1)), np.zeros((count, 2))
        cost = _look(window, (shown, moving, patches, light), numbers, chance, (slopes, own, push))
        matrix, right = np.zeros((count, band + 1)), np.empty((count, UNKNOWNS + 1))
        for k in range(count):
            matrix[k, band] = own[k, 1] * own[k, 0] ** 2
            right[k] = own[k, 1] * own[k, 0] * slopes[k]
        cost += _bind(patches, numbers, matrix, right)
        _factor(matrix)
        solved = right.copy()
        _solve(matrix, solved)
        _reduce(slopes, own, right, solved, sums)
        sums[:2, UNKNOWNS] += push
        if passing == 0:
            # The light first: before it is known no place can be told.
            sums[:2] = 0.0
            sums[:, :2] = 0.0
            sums[0, 0] = sums[1, 1] = 1.0
        step = np.linalg.solve(
            np.ascontiguousarray(sums[:, :UNKNOWNS]), np.ascontiguousarray(sums[:, UNKNOWNS])
        )
        light += step[2:]
        moved = math.sqrt(step[0] ** 2 + step[1] ** 2)
        pose[:2] += min(1.0, LARGEST_STEP_PX / max(moved, 1e-9)) * step[:2]
        for i in range(rows):
            for j in range(columns):
                k = numbers[i, j]
                if k >= 0:
                    patches[i, j] += solved[k, UNKNOWNS]
                    for m in range(UNKNOWNS):
                        patches[i, j] -= step[m] * solved[k, m]
        if passing >= LEAST_PASSES and moved < SETTLED_PX:
            break
    inverse = np.linalg.inv(np.ascontiguousarray(sums[:, :UNKNOWNS]))
    scale = cost / count
    found[:2] = pose[:2]
    found[2], found[3] = math.sqrt(scale * inverse[0, 0]), math.sqrt(scale * inverse[1, 1])
    found[4], found[5] = scale, count
    found[6] = math.sqrt((pose[0] - start[0]) ** 2 + (pose[1] - start[1]) ** 2)
    found[LEFT] = cost
    return found
