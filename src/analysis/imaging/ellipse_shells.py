"""Adaptive fuzzy c-shells for ellipses: every shell has a norm of its own (thesis, section 4.4).

R. N. Dave and K. Bhaswan, "Adaptive fuzzy c-shells clustering and detection of ellipses",
IEEE Trans. Neural Networks 3, 643-662 (1992), doi:10.1109/72.159055. A shell is the set of points
x with sqrt((x - v)' A (x - v)) = 1; its size and shape are in A, which the paper splits into a
matrix of determinant 1 and a radius.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.cholesky import factor, gram, solve
from analysis.compiled import compiled, part
from analysis.imaging.shells import FUZZIFIER, Ellipse, memberships

Floats = NDArray[np.float64]

LEAST_POINTS, SMALLEST_PX, TINY = 6, 1e-6, 1e-12
LONGEST_STEP = 0.5
"""Of one iteration, in units of the points' spread."""


@dataclass(frozen=True, slots=True, eq=False)
class _Scaled:
    """Points (points, 2) moved to their centre and divided by their spread, pixels."""

    points: Floats
    centre: Floats
    size: float


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


def fit_ellipses(
    row: Floats,
    column: Floats,
    start: Sequence[Ellipse],
    *,
    noise_distance: float | None = None,
    iterations: int = 60,
    tolerance: float = 1e-6,
) -> tuple[list[Ellipse], Floats] | None:
    """Fit ellipses to points shared out among them by fuzzy memberships.

    Minimises sum_i sum_k u_ik^m d_ik^2 with d = r (sqrt((x - v)' A (x - v)) - 1) and r^2 the
    product of the semi-axes, alternating between memberships and one Gauss-Newton step of each
    centre and norm.

    Parameters
    ----------
    row, column
        Points in pixels, shape (points,). At least 6 for each ellipse.
    start
        First guesses; circles do, within about a quarter of the radius.
    noise_distance
        Distance of the noise cluster in pixels; None: every point belongs to some ellipse.

    Returns
    -------
    The ellipses in the order of `start`, with the rms distance of their own points, and the
    memberships, shape (ellipses, points). None where some points do not close to an ellipse.
    """
    scaled = _scaled(row, column)
    states = np.array([_state(guess, scaled) for guess in start])
    u = _shares(scaled, states, noise_distance)
    for _ in range(iterations):
        steps = [
            _step(scaled.points, state, own**FUZZIFIER)
            for state, own in zip(states, u, strict=True)
        ]
        taken = np.array([step for step in steps if step is not None])
        if len(taken) < len(steps):
            return None
        states = states + taken
        if (_determinants(states) <= 0).any():
            return None
        u = _shares(scaled, states, noise_distance)
        if np.abs(taken).max() < tolerance:
            break
    fitted = [_ellipse(s, scaled, own**FUZZIFIER) for s, own in zip(states, u, strict=True)]
    ellipses = [ellipse for ellipse in fitted if ellipse is not None]
    return (ellipses, u) if len(ellipses) == len(fitted) else None


def _scaled(row: Floats, column: Floats) -> _Scaled:
    points = np.stack([row, column], 1)
    centre = points.mean(axis=0)
    size = float(np.sqrt(((points - centre) ** 2).sum(axis=1).mean()))
    return _Scaled((points - centre) / max(size, 1e-12), centre, size)


def _state(guess: Ellipse, scaled: _Scaled) -> Floats:
    """Return centre and norm (a11, a12, a22) of a guess in the scaled frame, shape (5,)."""
    c, s = np.cos(guess.angle), np.sin(guess.angle)
    axes = np.array([[c, -s], [s, c]])
    inverse = (scaled.size / np.array([guess.semi_major, guess.semi_minor])) ** 2
    norm = axes @ np.diag(inverse) @ axes.T
    centre = (np.array([guess.row, guess.column]) - scaled.centre) / scaled.size
    return np.array([*centre, norm[0, 0], norm[0, 1], norm[1, 1]])


def _determinants(states: Floats) -> Floats:
    return np.asarray(states[..., 2] * states[..., 4] - states[..., 3] ** 2)


def _norm_square(points: Floats, state: Floats) -> Floats:
    q = points - state[:2]
    mixed = 2 * state[3] * q[:, 0] * q[:, 1]
    return np.asarray(state[2] * q[:, 0] ** 2 + mixed + state[4] * q[:, 1] ** 2)


def _shares(scaled: _Scaled, states: Floats, noise_distance: float | None) -> Floats:
    """Return the memberships by the distances in pixels, shape (ellipses, points)."""
    norms = np.sqrt(np.clip([_norm_square(scaled.points, s) for s in states], 0.0, None))
    radius = scaled.size * np.clip(_determinants(states), 1e-12, None) ** -0.25
    return memberships((radius[:, None] * (norms - 1.0)) ** 2, noise_distance)


def _step(points: Floats, state: Floats, weight: Floats) -> Floats | None:
    """Return one Gauss-Newton step of centre and norm, None where the norm is none."""
    step = np.zeros(5)
    return step if ellipse_step(points, state, weight, step) else None


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


def _ellipse(state: Floats, scaled: _Scaled, weight: Floats) -> Ellipse | None:
    values, vectors = np.linalg.eigh(np.array([[state[2], state[3]], [state[3], state[4]]]))
    if values[0] <= 0:
        return None
    semi_major, semi_minor = scaled.size / np.sqrt(values)
    residual = np.sqrt(np.clip(_norm_square(scaled.points, state), 0.0, None)) - 1.0
    spread = float(np.sqrt((weight * residual**2).sum() / weight.sum()))
    return Ellipse(
        row=float(scaled.centre[0] + scaled.size * state[0]),
        column=float(scaled.centre[1] + scaled.size * state[1]),
        semi_major=float(semi_major),
        semi_minor=float(semi_minor),
        angle=float(np.arctan2(vectors[1, 0], vectors[0, 0])),
        rms_px=spread * float(np.sqrt(semi_major * semi_minor)),
    )
