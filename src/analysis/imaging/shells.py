"""Fuzzy c-shells: circles through edge points (thesis, section 4.4).

R. N. Dave and K. Bhaswan, "Adaptive fuzzy c-shells clustering and detection of ellipses",
IEEE Trans. Neural Networks 3, 643-662 (1992), doi:10.1109/72.159055. A noise cluster at a constant
distance takes the points that belong to no shell (R. N. Dave, "Characterization and detection of
noise in clustering", Pattern Recognition Letters 12, 657-664 (1991),
doi:10.1016/0167-8655(91)90002-4).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.cholesky import factor, gram, solve
from analysis.compiled import compiled, part

NO_NOISE = 1e9
"""Distance, pixels, of a noise cluster that takes no point."""
NEAREST, LEAST_SQUARE, LONGEST_STEP_PX = 1e-9, 1e-12, 3.0
"""Keep quotients finite, and one step within a marker's size."""


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
    # Whole numbers are found to a fraction of a pixel too.
    state = np.array([[c.row, c.column, c.radius] for c in start], dtype=np.float64)
    u, covariance = np.empty((len(state), row.size)), np.empty((len(state), 3, 3))
    distance = NO_NOISE if noise_distance is None else noise_distance
    until = (float(distance), iterations, tolerance_px)
    row, column = (np.ascontiguousarray(place, dtype=np.float64) for place in (row, column))
    settle_circles(row, column, (state, u, covariance), until, hold_radius)
    circles = [
        Circle(float(place[0]), float(place[1]), float(place[2]), own)
        for place, own in zip(state, covariance, strict=True)
    ]
    return circles, u


@part
def share_out(row: Floats, column: Floats, state: Floats, noise: float, u: Floats) -> None:
    """Fill each point's membership in each circle, shape (circles, points).

    u_ik = 1 / sum_j (D_ik / D_jk)^(1 / (m - 1)) of the squared distances D, the noise cluster being
    one more j at `noise`^2; m = 2 needs no further power.
    """
    noisy = 1.0 / noise**2
    for k in range(row.size):
        total = noisy
        for i in range(state.shape[0]):
            d_r, d_c = row[k] - state[i, 0], column[k] - state[i, 1]
            off = math.sqrt(d_r * d_r + d_c * d_c) - state[i, 2]
            u[i, k] = 1.0 / (off * off + LEAST_SQUARE)
            total += u[i, k]
        for i in range(state.shape[0]):
            u[i, k] /= total


@part
def circle_rows(row: Floats, column: Floats, circle: Floats, rows: Floats) -> None:
    """Fill the derivatives of the distance to a circle by -centre and -radius, and the distance.

    Parameters
    ----------
    rows
        Shape (4, points), as `cholesky.gram` takes them.
    """
    down, across, outward, off = rows[0], rows[1], rows[2], rows[3]
    r, c, radius = circle[0], circle[1], circle[2]
    for k in range(row.size):
        d_r, d_c = row[k] - r, column[k] - c
        rho = max(math.sqrt(d_r * d_r + d_c * d_c), NEAREST)
        down[k], across[k], outward[k], off[k] = d_r / rho, d_c / rho, 1.0, rho - radius


@part
def sandwich(rows: Floats, weight: Floats, size: int, covariance: Floats) -> None:
    """Fill the covariance of a circle: least squares with weights, by the points' own scatter."""
    normal, spread = np.empty((4, 4)), np.empty((4, 4))
    gram(rows, weight, normal)
    gram(rows, weight**2, spread)
    variance = normal[3, 3] / max(normal[2, 2] - 3.0, 1.0)
    covariance[:] = 0.0
    if not factor(normal, size):
        return
    inverse = np.zeros((3, 3))
    for a in range(size):
        inverse[a, a] = 1.0
        solve(normal, size, inverse[a])
    for a in range(size):
        for b in range(size):
            for p in range(size):
                for q in range(size):
                    middle = spread[max(p, q), min(p, q)]
                    covariance[a, b] += variance * inverse[a, p] * middle * inverse[b, q]


@part
def move_circle(rows: Floats, weight: Floats, size: int, circle: Floats) -> float:
    """Take one Gauss-Newton step; return its largest part, 0 where the points do not tell it."""
    normal, longest = np.empty((4, 4)), 0.0
    gram(rows, weight, normal)
    if not factor(normal, size):
        return 0.0
    step = normal[3]
    solve(normal, size, step)
    for a in range(size):
        longest = max(longest, abs(step[a]))
        circle[a] += min(max(step[a], -LONGEST_STEP_PX), LONGEST_STEP_PX)
    return longest


@compiled
def settle_circles(
    row: Floats,
    column: Floats,
    shells: tuple[Floats, Floats, Floats],
    until: tuple[float, int, float],
    hold_radius: bool,
) -> None:
    """Fit circles as `fit_circles` tells, in place.

    Parameters
    ----------
    shells
        Row, column and radius of each circle, improved, shape (circles, 3); filled: memberships,
        shape (circles, points), and covariances, shape (circles, 3, 3).
    until
        Distance of the noise cluster, pixels; most iterations; and the step, pixels, that is the
        last.
    """
    state, u, covariance = shells
    noise, iterations, tolerance = until
    size = 2 if hold_radius else 3
    rows = np.empty((4, row.size))
    for _ in range(iterations):
        share_out(row, column, state, noise, u)
        longest = 0.0
        for i in range(state.shape[0]):
            circle_rows(row, column, state[i], rows)
            longest = max(longest, move_circle(rows, u[i] ** 2, size, state[i]))
        if longest < tolerance:
            break
    share_out(row, column, state, noise, u)
    for i in range(state.shape[0]):
        circle_rows(row, column, state[i], rows)
        sandwich(rows, u[i] ** 2, size, covariance[i])


@part
def settle_circle(
    row: Floats, column: Floats, circle: Floats, size: int, until: tuple[float, int, float]
) -> tuple[Floats, Floats]:
    """Fit one circle beside the noise cluster, as `settle_circles` would.

    Parameters
    ----------
    circle
        Row, column and radius, improved, shape (3,).
    size
        3, or 2 to hold the radius.

    Returns
    -------
    `circle_rows` and the weights, memberships squared, of the last step, shape (points,).
    """
    rows, weight = np.empty((4, row.size)), np.empty(row.size)
    noisy, off = 1.0 / until[0] ** 2, rows[3]
    for _ in range(until[1]):
        circle_rows(row, column, circle, rows)
        for k in range(row.size):
            share = 1.0 / (1.0 + (off[k] * off[k] + LEAST_SQUARE) * noisy)
            weight[k] = share * share
        if move_circle(rows, weight, size, circle) < until[2]:
            break
    return rows, weight
