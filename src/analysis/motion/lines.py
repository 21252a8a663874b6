"""Straight lines through values whose errors last: generalised least squares, compiled."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.cholesky import factor, gram, solve
from analysis.compiled import compiled

Floats = NDArray[np.float64]


@compiled
def fit_axes(
    tau: Floats, values: Floats, sigmas: Floats, slow: Floats
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Fit a straight line to each coordinate, where it was measured.

    Parameters
    ----------
    tau
        Shape (frames,).
    values, sigmas
        Coordinates and their standard errors, infinite where not measured, shape (frames, 3).
    slow
        Covariance of what lasts, the same of each coordinate, shape (frames, frames).

    Returns
    -------
    Values at 0 and slopes, shape (2, 3); the same of tau^2 / 2 in the place of the values; the
    covariances, shape (3, 2, 2); chi-squared and number of frames, shape (3,).
    """
    state, bend, inverse = np.zeros((2, 3)), np.zeros((2, 3)), np.zeros((3, 2, 2))
    chi2, seen = np.zeros(3), np.zeros(3)
    used = np.zeros(tau.size, dtype=np.int64)
    for axis in range(3):
        count = 0
        for k in range(tau.size):
            if math.isfinite(sigmas[k, axis]):
                used[count] = k
                count += 1
        times, rows, spread = np.zeros(count), np.zeros((2, count)), np.zeros((count, count))
        for a in range(count):
            k = used[a]
            times[a], rows[0, a], rows[1, a] = tau[k], values[k, axis], tau[k] * tau[k] / 2
            for b in range(a + 1):
                spread[a, b] = slow[k, used[b]]
            spread[a, a] += sigmas[k, axis] ** 2
        lines, inverse[axis], squares = fit_lines(times, rows, spread)
        for k in range(2):
            state[k, axis], bend[k, axis] = lines[0, k], lines[1, k]
        chi2[axis], seen[axis] = squares[0], count
    return state, bend, inverse, chi2, seen


@compiled
def fit_lines(tau: Floats, values: Floats, spread: Floats) -> tuple[Floats, Floats, Floats]:
    """Fit a straight line through each of some rows of values with the same correlated errors.

    Parameters
    ----------
    tau, values
        Shapes (points,), at least 2, and (rows, points).
    spread
        Covariance of the values, shape (points, points); its lower triangle is used up.

    Returns
    -------
    Values at 0 and slopes, shape (rows, 2); their covariance, shape (2, 2); chi-squared, shape
    (rows,).

    Raises
    ------
    ValueError
        The covariance is not positive definite, or all points have one time.
    """
    count, rows = tau.size, values.shape[0]
    if not factor(spread, count):
        raise ValueError("the errors of a track must be positive and no two of them the same one")
    # Each column over the errors' root: constant, time and values.
    white, products = np.ones((2 + rows, count)), np.zeros((2 + rows, 2 + rows))
    white[1], white[2:] = tau, values
    for column in white:
        for a in range(count):
            left = column[a]
            for k in range(a):
                left -= spread[a, k] * column[k]
            column[a] = left / spread[a, a]
    gram(white, np.ones(count), products)
    normal, lines, inverse = products[:2, :2].copy(), products[2:, :2].copy(), np.eye(2)
    if not factor(normal, 2):
        raise ValueError("a line through one time has no slope: give two frames at least")
    chi2 = np.zeros(rows)
    for k in range(2):
        solve(normal, 2, inverse[k])
    for n in range(rows):
        solve(normal, 2, lines[n])
        for a in range(count):
            off = white[2 + n, a] - lines[n, 0] * white[0, a] - lines[n, 1] * white[1, a]
            chi2[n] += off * off
    return lines, inverse, chi2
