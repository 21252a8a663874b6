"""Fuzzy c-shells: circles through edge points (thesis, section 4.4).

R. N. Dave and K. Bhaswan, "Adaptive fuzzy c-shells clustering and detection of ellipses",
IEEE Trans. Neural Networks 3, 643-662 (1992), doi:10.1109/72.159055. A noise cluster at a constant
distance takes the points that belong to no shell (R. N. Dave, "Characterization and detection of
noise in clustering", Pattern Recognition Letters 12, 657-664 (1991),
doi:10.1016/0167-8655(91)90002-4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FUZZIFIER = 2.0
"""Exponent m of the memberships; with m = 2 the update needs no further power."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Circle:
    """A circle in pixels, with the covariance of (row, column, radius), shape (3, 3)."""

    row: float
    column: float
    radius: float
    covariance: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Ellipse:
    """An ellipse in pixels: centre, semi-axes, direction of the major axis, rms distance.

    `angle` is in radians from the row axis towards the column axis.
    """

    row: float
    column: float
    semi_major: float
    semi_minor: float
    angle: float
    rms_px: float


def memberships(squared_distances: Floats, noise_distance: float | None) -> Floats:
    """Return the membership of each point in each shell, shape (shells, points).

    u_ik = 1 / sum_j (D_ik / D_jk)^(1 / (m - 1)), the noise cluster being one more j at the
    squared distance `noise_distance`^2.
    """
    power = 1.0 / (FUZZIFIER - 1.0)
    closeness = (1.0 / (squared_distances + 1e-12)) ** power
    total = closeness.sum(axis=0)
    if noise_distance is not None:
        total = total + (1.0 / noise_distance**2) ** power
    return np.asarray(closeness / total)


def fit_circles(
    row: Floats,
    column: Floats,
    start: list[Circle],
    *,
    noise_distance: float | None = None,
    hold_radius: bool = False,
    iterations: int = 30,
    tolerance_px: float = 1e-4,
) -> tuple[list[Circle], Floats]:
    """Fit circles to points shared out among them by fuzzy memberships.

    Minimises sum_i sum_k u_ik^m (|x_k - v_i| - r_i)^2, alternating between memberships and one
    Gauss-Newton step of each centre and radius.

    Parameters
    ----------
    row, column
        Points in pixels, shape (points,). At least 3 for each circle.
    start
        First guesses; within about a quarter of the radius.
    noise_distance
        Distance of the noise cluster in pixels; None: every point belongs to some circle.
    hold_radius
        Keep the radii of `start`: what a limb that is half hidden cannot tell.

    Returns
    -------
    circles
        In the order of `start`. The covariance is that of the weighted least squares with the
        points' own scatter, as if they were independent.
    memberships
        Shape (circles, points).
    """
    state = np.array([[c.row, c.column, c.radius] for c in start])
    for _ in range(iterations):
        d_r, d_c, rho = _polar(row, column, state)
        distance = rho - state[:, 2:]
        u = memberships(distance**2, noise_distance)
        steps = np.zeros_like(state)
        for i in range(len(state)):
            jacobian = _jacobian(d_r[i], d_c[i], rho[i], hold_radius)
            weight = u[i] ** FUZZIFIER
            normal = jacobian.T @ (weight[:, None] * jacobian)
            steps[i] = np.linalg.lstsq(normal, jacobian.T @ (weight * distance[i]), rcond=None)[0]
        state = state + np.clip(steps, -3.0, 3.0)
        if np.abs(steps).max() < tolerance_px:
            break
    d_r, d_c, rho = _polar(row, column, state)
    distance = rho - state[:, 2:]
    u = memberships(distance**2, noise_distance)
    circles = []
    for i, (centre_row, centre_column, radius) in enumerate(state):
        jacobian = _jacobian(d_r[i], d_c[i], rho[i], hold_radius)
        covariance = _covariance(jacobian, distance[i], u[i])
        circles.append(Circle(float(centre_row), float(centre_column), float(radius), covariance))
    return circles, u


def _polar(row: Floats, column: Floats, state: Floats) -> tuple[Floats, Floats, Floats]:
    d_r = row[None, :] - state[:, 0:1]
    d_c = column[None, :] - state[:, 1:2]
    return d_r, d_c, np.maximum(np.hypot(d_r, d_c), 1e-9)


def _jacobian(d_r: Floats, d_c: Floats, rho: Floats, hold_radius: bool) -> Floats:
    by_radius = np.zeros_like(rho) if hold_radius else np.ones_like(rho)
    return np.stack([d_r / rho, d_c / rho, by_radius], 1)


def _covariance(jacobian: Floats, distance: Floats, u: Floats) -> Floats:
    weight = u**FUZZIFIER
    normal = jacobian.T @ (weight[:, None] * jacobian)
    freedom = max(weight.sum() - 3.0, 1.0)
    variance = float((weight * distance**2).sum() / freedom)
    spread = jacobian.T @ ((weight**2)[:, None] * jacobian)
    inverse = np.linalg.pinv(normal)
    return np.asarray(variance * inverse @ spread @ inverse)
