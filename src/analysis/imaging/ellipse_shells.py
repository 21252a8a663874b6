"""Adaptive fuzzy c-shells for ellipses: every shell has a norm of its own (thesis, section 4.4).

R. N. Dave and K. Bhaswan, "Adaptive fuzzy c-shells clustering and detection of ellipses",
IEEE Trans. Neural Networks 3, 643-662 (1992), doi:10.1109/72.159055. A shell is the set of points
x with sqrt((x - v)' A (x - v)) = 1; its size and shape are in A, which the paper splits into a
matrix of determinant 1 and a radius.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.shells import FUZZIFIER, Ellipse, memberships

Floats = NDArray[np.float64]

LEAST_POINTS = 6
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
    scaled = _scaled(row, column)
    if scaled.size < 1e-6:
        return None
    state = np.array([0.0, 0.0, 1.0, 0.0, 1.0])
    weight = np.ones(row.size)
    for _ in range(iterations):
        step = _step(scaled.points, state, weight)
        if step is None:
            return None
        state = state + step
        if np.abs(step).max() < tolerance:
            break
    return _ellipse(state, scaled, weight)


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
    square = _norm_square(points, state)
    if (square <= 0).any():
        return None
    norm, q = np.sqrt(square), points - state[:2]
    by_centre = -np.stack(
        [state[2] * q[:, 0] + state[3] * q[:, 1], state[3] * q[:, 0] + state[4] * q[:, 1]], 1
    )
    by_norm = np.stack([q[:, 0] ** 2 / 2, q[:, 0] * q[:, 1], q[:, 1] ** 2 / 2], 1)
    root = np.sqrt(weight)
    jacobian = np.concatenate([by_centre, by_norm], 1) / norm[:, None] * root[:, None]
    step = np.linalg.lstsq(jacobian, (1.0 - norm) * root, rcond=None)[0]
    return np.clip(step, -LONGEST_STEP, LONGEST_STEP)


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
