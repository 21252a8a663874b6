"""How much of each pixel a marker covers, and how that changes with the pose.

A marker is a cap of the sphere. Its visible part is bounded by its rim and, where the limb cuts
it, by an arc of the limb. The blurred cover of a pixel is a contour integral (Green's theorem):
the Gaussian's cumulative across the columns times the Gaussian across the rows. Both factors
depend on one coordinate only and end a few blurs away from the point: before it the cumulative is 1
(`before`), beyond it nothing.
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
REACH_SIGMAS, POINT_SIGMAS = 4.5, 5.0
"""How far the blur of a whole cover is drawn, and that of one point of its contour.

Points that do not quite close a contour which the limb cuts cover pixels before it a little."""
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
    points, radius = np.empty((MOST_POINTS, 6)), place[2]
    count = contour_points(marker, alpha, radius, sigma, points)
    if count == 0:
        return
    at = (place[0] - corner[0], place[1] - corner[1], radius)
    first_r, last_r, first_c, last_c = box_of(points, count, at, REACH_SIGMAS * sigma)
    first_r, last_r = max(first_r, 0), min(last_r, canvas.shape[0])
    first_c, last_c = max(first_c, 0), min(last_c, canvas.shape[2])
    if first_r >= last_r or first_c >= last_c:
        return
    layers, height, width = canvas.shape[1], last_r - first_r, last_c - first_c
    box, before = np.zeros(height * width * layers), np.zeros((height, width + 1))
    factors, room = np.empty(layers), np.empty(width * layers)
    for k in range(count):
        point_factors(points[k], radius, sigma, factors)
        if layers > LAYERS:
            growth_factors(points[k], marker, alpha, radius, factors)
        where = (at[0] + radius * points[k, 0] - first_r, at[1] + radius * points[k, 1] - first_c)
        add_point(where, sigma, (factors, room), box, before)
    add_box(canvas, (first_r, first_c), box, before)


@part
def reached(middle: float, sigma: float, size: int) -> tuple[int, int]:
    """Return the half-open pixels of a box, along one side, that the blur of a point reaches."""
    first = math.ceil(middle - POINT_SIGMAS * sigma)
    last = math.floor(middle + POINT_SIGMAS * sigma) + 1
    return min(max(first, 0), size), min(max(last, 0), size)


@part
def add_point(
    where: tuple[float, float],
    sigma: float,
    weights: tuple[Floats, Floats],
    box: Floats,
    before: Floats,
) -> None:
    """Add what one point of a contour gives to the pixels that its blur reaches.

    Their layers lie side by side, so that a row of pixels is one vector.

    Parameters
    ----------
    where
        Row and column of the point within the box.
    weights
        Those of the point in each layer, shape (layers,), and room for a row of the box.
    box
        Added to, shape (rows * columns * layers,).
    before
        Added to: cover of all pixels of a row before a column, shape (rows, columns + 1).
    """
    factors, room = weights
    layers, height, width = factors.shape[0], before.shape[0], before.shape[1] - 1
    first_r, last_r = reached(where[0], sigma, height)
    first_c, last_c = reached(where[1], sigma, width)
    filled = np.uint64(0)
    for j in range(first_c, last_c):
        share, bell = gaussian((where[1] - j) / sigma)
        # Two loops, here and in `add_box`: the compiler unrolls the one whose length it knows.
        room[filled] = factors[0] * share
        for layer in range(1, LAYERS):
            room[filled + np.uint64(layer)] = factors[layer] * bell
        for layer in range(LAYERS, layers):
            room[filled + np.uint64(layer)] = factors[layer] * bell
        filled += np.uint64(layers)
    for i in range(first_r, last_r):
        bell = gaussian((where[0] - i) / sigma)[1]
        before[i, first_c] += factors[0] * bell
        start = np.uint64((i * width + first_c) * layers)
        for n in range(filled):
            box[start + n] += bell * room[n]


@part
def add_box(canvas: Floats, first: tuple[int, int], box: Floats, before: Floats) -> None:
    """Add a box of `add_point` to a canvas, given where in it the box starts."""
    layers, width = canvas.shape[1], before.shape[1] - 1
    for i in range(before.shape[0]):
        own, left = canvas[first[0] + i], 0.0
        for j in range(width - 1, -1, -1):
            left += before[i, j + 1]
            start = np.uint64((i * width + j) * layers)
            own[0, first[1] + j] += left
            for layer in range(LAYERS):
                own[layer, first[1] + j] += box[start + np.uint64(layer)]
            for layer in range(LAYERS, layers):
                own[layer, first[1] + j] += box[start + np.uint64(layer)]


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
