"""How much of each pixel a marker covers, and how that changes with the pose.

A marker is a cap of the sphere. Its visible part is bounded by its rim and, where the limb cuts
it, by an arc of the limb. The blurred cover of a pixel is a contour integral (Green's theorem):
the Gaussian's cumulative across the columns times the Gaussian across the rows. Both factors
depend on one coordinate only, so that the cover is a product of two matrices, the one rows by
points, the other points by columns.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import ndtr

from analysis.arrays import Floats
from analysis.compiled import compiled, part

LAYERS = 6
"""Cover, its derivatives to row and column of the centre, and to turns about row, column, eye."""
GROWTHS = 2
"""Layers of a deeper canvas behind them: derivatives to the cap's angular radius and to the log
radius of the sphere."""
ALPHA, RADIUS = LAYERS, LAYERS + 1
REACH_SIGMAS = 4.5
MOST_POINTS = 256
FURTHEST = 6.0
PER_SIGMA = 64
"""Steps of the tabulated Gaussian; a parabola about the nearest is within 1e-6."""
_AT = np.arange(-int(FURTHEST * PER_SIGMA), int(FURTHEST * PER_SIGMA) + 1) / PER_SIGMA
GAUSSIAN = np.stack([ndtr(_AT), np.exp(-0.5 * _AT**2) / math.sqrt(2 * math.pi)], axis=1)
"""Cumulative and density."""
RIM_SPACING = 1.2
CUT_SPACING = 0.6
"""Spacing of points in units of the blur: a whole rim is periodic and needs fewer."""


@part
def faces(marker: Floats, alpha: float) -> bool:
    """Whether any part of a cap about a direction (row, column, eye) is visible."""
    flat = math.sqrt(marker[0] * marker[0] + marker[1] * marker[1])
    return bool(-marker[2] * math.cos(alpha) < flat * math.sin(alpha))


@part
def contour_points(
    marker: Floats, alpha: float, radius: float, sigma: float, points: Floats
) -> int:
    """Place points on the boundary of the visible part of a cap.

    Parameters
    ----------
    marker
        Direction as (row, column, towards the eye), shape (3,).
    points
        Filled with row, column, height in units of the radius, steps of row and column, and 1 on
        the rim or 0 on the limb; shape (MOST_POINTS, 6).

    Returns
    -------
    The number of points; 0 where the cap is hidden.
    """
    m_r, m_c, m_z = marker[0], marker[1], marker[2]
    ca, sa = math.cos(alpha), math.sin(alpha)
    sb = math.sqrt(m_r * m_r + m_c * m_c)
    whole = m_z * ca >= sa * sb
    if not whole and not faces(marker, alpha):
        return 0
    if sb > 1e-9:
        l_r, l_c = m_r / sb, m_c / sb
    else:
        l_r, l_c = 1.0, 0.0
    t_r, t_c, t_z = -m_z * l_r, -m_z * l_c, sb
    b_r, b_c = l_c, -l_r
    half = math.pi if whole else math.acos(-m_z * ca / (sa * sb))
    spacing = (RIM_SPACING if whole else CUT_SPACING) * sigma
    n = math.ceil(2 * half * sa * radius / spacing)
    n = min(max(n, 12 if whole else 6), MOST_POINTS // 2)
    step = 2 * half / n
    for k in range(n):
        phi = -half + (k + 0.5) * step
        c, s = math.cos(phi) * sa, math.sin(phi) * sa
        points[k, 0] = ca * m_r + c * t_r + s * b_r
        points[k, 1] = ca * m_c + c * t_c + s * b_c
        points[k, 2] = ca * m_z + c * t_z
        points[k, 3] = (-s * t_r + c * b_r) * step
        points[k, 4] = (-s * t_c + c * b_c) * step
        points[k, 5] = 1.0
    if whole:
        return n
    reach = math.acos(min(1.0, ca / sb))
    more = min(max(math.ceil(2 * reach * radius / spacing), 6), MOST_POINTS // 2)
    step = 2 * reach / more
    for k in range(n, n + more):
        g = -reach + (k - n + 0.5) * step
        c, s = math.cos(g), math.sin(g)
        points[k, 0] = c * l_r - s * l_c
        points[k, 1] = c * l_c + s * l_r
        points[k, 2] = 0.0
        points[k, 3] = (-s * l_r - c * l_c) * step
        points[k, 4] = (-s * l_c + c * l_r) * step
        points[k, 5] = 0.0
    return n + more


@part
def gaussian(x: float) -> tuple[float, float]:
    """Return the cumulative and the density of the normal distribution."""
    x = min(max(x, -FURTHEST), FURTHEST)
    i = int((x + FURTHEST) * PER_SIGMA + 0.5)
    off = x - (i / PER_SIGMA - FURTHEST)
    share, bell = GAUSSIAN[i, 0], GAUSSIAN[i, 1]
    slope = bell * (off - x)
    bend = bell * (x * x - 1.0)
    return share + off * (bell + 0.5 * off * slope), bell + off * (slope + 0.5 * off * bend)


@part
def box_of(
    points: Floats, count: int, at: tuple[float, float, float], margin: float
) -> tuple[int, int, int, int]:
    """Return the half-open rows and columns that a contour's blur reaches.

    Parameters
    ----------
    at
        Row and column of the disc's centre within the canvas, and its radius, pixels.
    """
    low_r, high_r, low_c, high_c = 1e9, -1e9, 1e9, -1e9
    for k in range(count):
        low_r, high_r = min(low_r, points[k, 0]), max(high_r, points[k, 0])
        low_c, high_c = min(low_c, points[k, 1]), max(high_c, points[k, 1])
    return (
        math.ceil(at[0] + at[2] * low_r - margin),
        math.floor(at[0] + at[2] * high_r + margin) + 1,
        math.ceil(at[1] + at[2] * low_c - margin),
        math.floor(at[1] + at[2] * high_c + margin) + 1,
    )


@compiled
def add_cover(
    canvas: Floats,
    corner: tuple[int, int],
    place: tuple[float, float, float],
    marker: Floats,
    cap: tuple[float, float],
) -> None:
    """Add one marker's cover and its derivatives to a canvas.

    Parameters
    ----------
    canvas
        Shape (rows, LAYERS, columns), or (rows, LAYERS + GROWTHS, columns).
    corner
        Row and column of the canvas's first pixel.
    place
        Row, column and radius of the disc, pixels.
    marker
        Direction as (row, column, towards the eye), shape (3,).
    cap
        Angular radius, radians, and standard deviation of the blur, pixels.
    """
    alpha, sigma = cap
    layers = canvas.shape[1]
    points = np.empty((MOST_POINTS, 6))
    radius = place[2]
    count = contour_points(marker, alpha, radius, sigma, points)
    if count == 0:
        return
    at = (place[0] - corner[0], place[1] - corner[1], radius)
    first_r, last_r, first_c, last_c = box_of(points, count, at, REACH_SIGMAS * sigma)
    first_r, last_r = max(first_r, 0), min(last_r, canvas.shape[0])
    first_c, last_c = max(first_c, 0), min(last_c, canvas.shape[2])
    if first_r >= last_r or first_c >= last_c:
        return
    down = np.empty((last_r - first_r, count))
    share, bell = np.empty((count, last_c - first_c)), np.empty((count, last_c - first_c))
    factors = np.empty((layers, count))
    for k in range(count):
        p_r, p_c = at[0] + radius * points[k, 0] - first_r, at[1] + radius * points[k, 1] - first_c
        for j in range(share.shape[1]):
            share[k, j], bell[k, j] = gaussian((p_c - j) / sigma)
        for i in range(down.shape[0]):
            down[i, k] = gaussian((p_r - i) / sigma)[1]
        point_factors(points[k], radius, sigma, factors[:, k])
        if layers > LAYERS:
            growth_factors(points[k], marker, alpha, radius, factors[:, k])
    left = np.empty((layers, down.shape[0], count))
    for layer in range(layers):
        for i in range(down.shape[0]):
            for k in range(count):
                left[layer, i, k] = factors[layer, k] * down[i, k]
    add_layers(canvas, (first_r, first_c), left, share, bell)


@part
def point_factors(point: Floats, radius: float, sigma: float, factors: Floats) -> None:
    """Fill a contour point's weight in each layer, shape (LAYERS,)."""
    # The contour runs clockwise, so that the area comes out negative.
    d_r, d_c = -radius / sigma * point[3], -radius / sigma * point[4]
    factors[0] = d_r
    d_r, d_c = d_r / sigma, d_c / sigma
    turning = radius * point[5]
    factors[1], factors[2] = -d_c, d_r
    factors[3], factors[4] = -turning * point[2] * d_r, -turning * point[2] * d_c
    factors[5] = turning * (point[0] * d_r + point[1] * d_c)


@part
def growth_factors(
    point: Floats, marker: Floats, alpha: float, radius: float, factors: Floats
) -> None:
    """Fill a contour point's weight in the layers behind LAYERS.

    A contour that moves changes the cover as if the disc's centre moved by as much there.
    """
    to_row, to_column, rim = factors[1] * radius, factors[2] * radius, point[5]
    ca, sa = math.cos(alpha), math.sin(alpha)
    outwards_r, outwards_c = (ca * point[0] - marker[0]) / sa, (ca * point[1] - marker[1]) / sa
    factors[ALPHA] = rim * (outwards_r * to_row + outwards_c * to_column)
    factors[RADIUS] = point[0] * to_row + point[1] * to_column


@part
def add_layers(
    canvas: Floats, first: tuple[int, int], left: Floats, share: Floats, bell: Floats
) -> None:
    """Add the products over all points: the cover with the cumulative, its slopes with the bell.

    Parameters
    ----------
    first
        Row and column of the canvas where they start.
    left
        Shape (layers, rows, points), as many as the canvas has.
    share, bell
        Shapes (points, columns).
    """
    layers, rows, columns = left.shape[0], left.shape[1], np.uint64(share.shape[1])
    cover = np.dot(left[0], share)
    slopes = np.dot(left[1:].reshape((layers - 1) * rows, left.shape[2]), bell)
    # Unsigned indices spare the check for negative ones and become vector instructions.
    flat, start = canvas.reshape(-1), np.uint64(canvas.shape[2])
    for i in range(rows):
        at = np.uint64(layers * (first[0] + i)) * start + np.uint64(first[1])
        for j in range(columns):
            flat[at + j] += cover[i, j]
        for layer in range(layers - 1):
            at += start
            own = slopes[layer * rows + i]
            for j in range(columns):
                flat[at + j] += own[j]
