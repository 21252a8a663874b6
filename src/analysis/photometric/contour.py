"""How much of each pixel a marker covers, and how that changes with the pose.

A marker is a cap of the sphere. Its visible part is bounded by its rim and, where the limb cuts
it, by an arc of the limb. The blurred cover of a pixel is a contour integral (Green's theorem):
the Gaussian's cumulative across the columns times the Gaussian across the rows. Both factors
depend on one coordinate only, so a point of the contour adds an outer product.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from analysis.photometric.compiled import compiled

Floats = NDArray[np.float64]

LAYERS = 6
"""Cover, its derivatives to row and column of the centre, and to turns about row, column, eye."""
REACH_SIGMAS = 4.0
MOST_POINTS = 256
PER_SIGMA = 128
"""Steps of the tabulated Gaussian; straight lines between them are within 2e-6."""
_AT = np.arange(-int(6 * PER_SIGMA), int(6 * PER_SIGMA) + 2) / PER_SIGMA
BELL = np.exp(-0.5 * _AT**2) / math.sqrt(2 * math.pi)
SHARE = ndtr(_AT)
RIM_SPACING = 1.0
CUT_SPACING = 0.6
"""Spacing of points in units of the blur: a whole rim is periodic and needs fewer."""


@compiled
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
    if not whole and -m_z * ca >= sa * sb:
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


@compiled
def look_up(table: Floats, x: float) -> float:
    """Return BELL or SHARE at x standard deviations."""
    place = (min(max(x, -6.0), 6.0) + 6.0) * PER_SIGMA
    i = int(place)
    t = place - i
    return float((1.0 - t) * table[i] + t * table[i + 1])


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
        Shape (LAYERS, rows, columns).
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
    points = np.empty((MOST_POINTS, 6))
    radius = place[2]
    count = contour_points(marker, alpha, radius, sigma, points)
    if count == 0:
        return
    rows, columns = canvas.shape[1], canvas.shape[2]
    low_r, high_r, low_c, high_c = 1e9, -1e9, 1e9, -1e9
    for k in range(count):
        low_r, high_r = min(low_r, points[k, 0]), max(high_r, points[k, 0])
        low_c, high_c = min(low_c, points[k, 1]), max(high_c, points[k, 1])
    margin = REACH_SIGMAS * sigma
    at_r, at_c = place[0] - corner[0], place[1] - corner[1]
    first_r = max(int(at_r + radius * low_r - margin), 0)
    last_r = min(int(at_r + radius * high_r + margin) + 2, rows)
    first_c = max(int(at_c + radius * low_c - margin), 0)
    last_c = min(int(at_c + radius * high_c + margin) + 2, columns)
    if first_r >= last_r or first_c >= last_c:
        return
    bell, share = np.empty(last_c - first_c), np.empty(last_c - first_c)
    for k in range(count):
        p_r, p_c = at_r + radius * points[k, 0], at_c + radius * points[k, 1]
        # The contour runs clockwise, so that the area comes out negative.
        d_r, d_c = -radius * points[k, 3], -radius * points[k, 4]
        for j in range(first_c, last_c):
            x = (p_c - j) / sigma
            bell[j - first_c] = look_up(BELL, x) / sigma
            share[j - first_c] = look_up(SHARE, x)
        turning = radius * points[k, 5]
        about_r = -turning * points[k, 2] * d_r
        about_c = -turning * points[k, 2] * d_c
        about_z = turning * (points[k, 0] * d_r + points[k, 1] * d_c)
        for i in range(first_r, last_r):
            across = look_up(BELL, (p_r - i) / sigma) / sigma
            for j in range(first_c, last_c):
                canvas[0, i, j] += across * d_r * share[j - first_c]
            for j in range(first_c, last_c):
                both = across * bell[j - first_c]
                canvas[1, i, j] -= both * d_c
                canvas[2, i, j] += both * d_r
                canvas[3, i, j] += both * about_r
                canvas[4, i, j] += both * about_c
                canvas[5, i, j] += both * about_z
