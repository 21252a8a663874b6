"""An ellipse by the adaptive norm of c-shells: the shell has a norm of its own (thesis, 4.4).

R. N. Dave and K. Bhaswan, "Adaptive fuzzy c-shells clustering and detection of ellipses",
IEEE Trans. Neural Networks 3, 643-662 (1992), doi:10.1109/72.159055. A shell is the set of points
x with sqrt((x - v)' A (x - v)) = 1; its size and shape are in A, which the paper splits into a
matrix of determinant 1 and a radius.
"""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.cholesky import factor, gram, solve
from analysis.compiled import compiled, part
from analysis.imaging.shells import Ellipse

LEAST_POINTS, SMALLEST_PX, TINY = 6, 1e-6, 1e-12
LONGEST_STEP = 0.5
"""Of one iteration, in units of the points' spread."""


def fit_ellipse(
    row: Floats, column: Floats, *, iterations: int = 30, tolerance: float = 1e-6
) -> Ellipse | None:
    """Fit one ellipse with the adaptive norm of c-shells: sqrt((x - v)' A (x - v)) = 1.

    Parameters
    ----------
    row, column
        Points in pixels, shape (points,), at least 6 and all of them on the ellipse.

    Returns
    -------
    None where the points do not close to an ellipse.
    """
    if row.size < LEAST_POINTS:
        return None
    found = np.empty(6)
    row, column = np.ascontiguousarray(row), np.ascontiguousarray(column)
    if not settle_ellipse(row, column, (iterations, tolerance), found):
        return None
    return Ellipse(*map(float, found))


@compiled
def ellipse_step(points: Floats, state: Floats, weight: Floats, step: Floats) -> bool:
    """Fill one Gauss-Newton step of centre and norm; false where the norm is none.

    Parameters
    ----------
    points
        Shape (points, 2), scaled.
    state
        Centre and norm (a11, a12, a22), shape (5,).
    """
    count, rows, least = points.shape[0], np.empty((6, points.shape[0])), 1.0
    middle_x, middle_y, a_11, a_12, a_22 = state[0], state[1], state[2], state[3], state[4]
    for k in range(count):
        x, y = points[k, 0] - middle_x, points[k, 1] - middle_y
        a_x, a_y = a_11 * x + a_12 * y, a_12 * x + a_22 * y
        square = a_x * x + a_y * y
        least = min(least, square)
        norm = math.sqrt(max(square, TINY))
        rows[0, k], rows[1, k], rows[2, k] = -a_x / norm, -a_y / norm, 0.5 * x * x / norm
        rows[3, k], rows[4, k], rows[5, k] = x * y / norm, 0.5 * y * y / norm, 1.0 - norm
    step[:] = 0.0
    if least <= 0.0:
        return False
    normal = np.empty((6, 6))
    gram(rows, weight, normal)
    if not factor(normal, 5):
        return False
    solve(normal, 5, normal[5])
    for a in range(5):
        step[a] = min(max(normal[5, a], -LONGEST_STEP), LONGEST_STEP)
    return True


@part
def norm_of_moments(points: Floats, state: Floats) -> None:
    """Start from the norm of the ellipse whose rim has the points' second moments.

    Points all round a rim have half the square of each semi-axis for their variance along it.
    """
    r_r, r_c, c_c = 0.0, 0.0, 0.0
    for k in range(points.shape[0]):
        r_r += points[k, 0] * points[k, 0]
        r_c += points[k, 0] * points[k, 1]
        c_c += points[k, 1] * points[k, 1]
    apart = r_r * c_c - r_c * r_c
    if apart > SMALLEST_PX * r_r * c_c:
        half = 0.5 * points.shape[0] / apart
        state[2], state[3], state[4] = half * c_c, -half * r_c, half * r_r


@compiled
def settle_ellipse(row: Floats, column: Floats, until: tuple[int, float], ellipse: Floats) -> bool:
    """Fit an ellipse as `fit_ellipse` tells; false where the points do not close to one.

    Parameters
    ----------
    until
        Most iterations, and the step that is the last.
    ellipse
        Filled in the order of `shells.Ellipse`, shape (6,).
    """
    centre_r, centre_c = row.mean(), column.mean()
    spread = math.sqrt(((row - centre_r) ** 2 + (column - centre_c) ** 2).mean())
    if spread < SMALLEST_PX:
        return False
    points, weight = np.empty((row.size, 2)), np.ones(row.size)
    points[:, 0], points[:, 1] = (row - centre_r) / spread, (column - centre_c) / spread
    state, step = np.array([0.0, 0.0, 1.0, 0.0, 1.0]), np.zeros(5)
    norm_of_moments(points, state)
    for _ in range(until[0]):
        if not ellipse_step(points, state, weight, step):
            return False
        state += step
        if np.abs(step).max() < until[1]:
            break
    middle, half = (state[2] + state[4]) / 2, (state[2] - state[4]) / 2
    apart = math.hypot(half, state[3])
    if middle - apart <= 0.0:
        return False
    squares = 0.0
    for k in range(row.size):
        x, y = points[k, 0] - state[0], points[k, 1] - state[1]
        square = state[2] * x * x + 2 * state[3] * x * y + state[4] * y * y
        squares += (math.sqrt(max(square, 0.0)) - 1.0) ** 2
    ellipse[0], ellipse[1] = centre_r + spread * state[0], centre_c + spread * state[1]
    ellipse[2], ellipse[3] = spread / math.sqrt(middle - apart), spread / math.sqrt(middle + apart)
    ellipse[4] = 0.5 * (math.atan2(state[3], half) + math.pi)
    ellipse[5] = math.sqrt(squares / row.size * ellipse[2] * ellipse[3])
    return True
