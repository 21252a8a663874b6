"""Whitened residuals of poses and their slopes by the numbers of both flights, block by block.

A block is the positions or the orientations of one sphere: position of a, orientation of a,
position of b, orientation of b.
"""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.motion.turning import turn_between

SMALL_SINE = 5e-10


@compiled
def misfits(
    observed: tuple[Floats, Floats], predicted: tuple[Floats, Floats], sigmas: tuple[Floats, Floats]
) -> Floats:
    """Return (observed - predicted) / sigma, zero where sigma is infinite, shape (S, 4, 3 F).

    Parameters
    ----------
    observed, predicted
        Positions, m, shape (S, F, 2, 3), and orientations, (S, F, 2, 3, 3); these differ by the
        rotation vector of R_observed R_predicted'.
    sigmas
        Standard errors, m, and about each axis, rad, shape (S, F, 2, 3).
    """
    shots, frames = sigmas[1].shape[0], sigmas[1].shape[1]
    residual = np.empty((shots, 4, 3 * frames))
    for s in range(shots):
        for f in range(frames):
            for i in range(2):
                for k in range(3):
                    off = observed[0][s, f, i, k] - predicted[0][s, f, i, k]
                    residual[s, 2 * i, 3 * f + k] = off * weight_of(sigmas[0][s, f, i, k])
                turn = residual[s, 2 * i + 1, 3 * f : 3 * f + 3]
                _turn(predicted[1][s, f, i], observed[1][s, f, i], turn)
                for k in range(3):
                    turn[k] *= weight_of(sigmas[1][s, f, i, k])
    return residual


@compiled
def put_whitened(change: Floats, weights: Floats, kind: int, step: float, column: Floats) -> None:
    """Put a change over its step, whitened, in its place among residuals (S, 4, 3 F).

    Parameters
    ----------
    change
        Of positions, m, or of orientations, rad, shape (S, F, 2, 3).
    weights
        1 / sigma of both, shape (S, F, 2, 6).
    kind
        0: positions, 1: orientations.
    """
    shots, frames = change.shape[0], change.shape[1]
    for s in range(shots):
        for f in range(frames):
            for i in range(2):
                for k in range(3):
                    own = change[s, f, i, k] * weights[s, f, i, 3 * kind + k] / step
                    column[s, 2 * i + kind, 3 * f + k] = own


@compiled
def slopes_of(
    times: tuple[Floats, Floats],
    turns: tuple[Floats, Floats],
    response: Floats,
    sigmas: tuple[Floats, Floats],
) -> tuple[Floats, Floats]:
    """Differentiate the poses by the flights' numbers, over sigma, shape (S, 4, 3 F, 12).

    The twelve: before and after contact, start and rate, three axes. With the slopes comes what
    they are times each other, shape (S, 4, 12, 12).

    Parameters
    ----------
    times
        tau of each coordinate, s, shape (S, F, 2, 3), and of the orientation, (S, F, 2).
    turns
        exp(spin tau) and the left Jacobian of spin tau, shape (S, F, 2, 3, 3).
    response
        Derivative of the position seen by the true one, shape (S, F, 2, 3, 3); none, of shape
        (0, F, 2, 3, 3), where they are the same.
    sigmas
        As of `misfits`.
    """
    shots, frames = sigmas[1].shape[0], sigmas[1].shape[1]
    slopes, gram = np.zeros((shots, 4, 3 * frames, 12)), np.zeros((shots, 4, 12, 12))
    for s in range(shots):
        for f in range(frames):
            for i in range(2):
                rows, squares = slopes[s, 2 * i, 3 * f : 3 * f + 3], gram[s, 2 * i]
                taus, whole = times[0][s, f, i], response.shape[0] == 0
                for k in range(3):
                    weight = weight_of(sigmas[0][s, f, i, k])
                    if whole:
                        _put(rows[k], k, taus[k], weight)
                        _square(rows[k], k + (6 if taus[k] > 0 else 0), 3, squares)
                        continue
                    for axis in range(3):
                        _put(rows[k], axis, taus[axis], weight * response[s, f, i, k, axis])
                    _square(rows[k], 0, 1, squares)
                tau = times[1][s, f, i]
                rows, squares = slopes[s, 2 * i + 1, 3 * f : 3 * f + 3], gram[s, 2 * i + 1]
                first = 6 if tau > 0 else 0
                for k in range(3):
                    weight = weight_of(sigmas[1][s, f, i, k])
                    for axis in range(3):
                        rows[k, first + axis] = weight * turns[0][s, f, i, k, axis]
                        rows[k, first + 3 + axis] = weight * tau * turns[1][s, f, i, k, axis]
                _square_side(rows, first, squares)
        for block in range(4):
            for a in range(12):
                for b in range(a):
                    gram[s, block, b, a] = gram[s, block, a, b]
    return slopes, gram


@part
def _square(row: Floats, first: int, pace: int, product: Floats) -> None:
    """Add a row's squares to the lower triangle: of two numbers, or with pace 1 of all."""
    last = 12 if pace == 1 else first + pace + 1
    for a in range(first, last, pace):
        for b in range(first, a + 1, pace):
            product[a, b] += row[a] * row[b]


@part
def _square_side(rows: Floats, first: int, product: Floats) -> None:
    """Add three rows' squares to the lower triangle, where they are of one side of contact."""
    for a in range(first, first + 6):
        for b in range(first, a + 1):
            product[a, b] += rows[0, a] * rows[0, b] + rows[1, a] * rows[1, b]
            product[a, b] += rows[2, a] * rows[2, b]


@part
def weight_of(sigma: float) -> float:
    """Return 1 / sigma, zero where it is not finite."""
    return 1.0 / sigma if math.isfinite(sigma) else 0.0


@part
def _put(row: Floats, axis: int, tau: float, slope: float) -> None:
    """Put a slope by place and by velocity on the side of contact that a time lies on."""
    first = (6 if tau > 0 else 0) + axis
    row[first], row[first + 3] = slope, slope * tau


@part
def _turn(first: Floats, second: Floats, vector: Floats) -> None:
    """Fill axis times angle, rad, of the turn second first'."""
    xx = second[0, 0] * first[0, 0] + second[0, 1] * first[0, 1] + second[0, 2] * first[0, 2]
    yy = second[1, 0] * first[1, 0] + second[1, 1] * first[1, 1] + second[1, 2] * first[1, 2]
    zz = second[2, 0] * first[2, 0] + second[2, 1] * first[2, 1] + second[2, 2] * first[2, 2]
    if xx + yy + zz < 1.0:
        # Beyond 90 degrees the skew part loses the axis as the sine vanishes.
        vector[:] = turn_between(first, second)
        return
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        below, above = 0.0, 0.0
        for n in range(3):
            below += second[j, n] * first[i, n]
            above += second[i, n] * first[j, n]
        vector[k] = 0.5 * (below - above)
    sine = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    if sine > SMALL_SINE:
        factor = math.atan2(sine, 0.5 * (xx + yy + zz - 1.0)) / sine
        for k in range(3):
            vector[k] *= factor
