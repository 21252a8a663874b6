"""From pixels along the gradient to the zeros of their facets, many side by side in vectors.

The facet is the biquadratic through 3 x 3 values (`facet`); along a line it is a polynomial of the
fourth degree. The pixels lie in bands: a value of all of them is a lane, and the lanes follow each
other in one array, so that the compiler knows that they are apart.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part

Filtered = tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]
"""Laplacian of the smoothed frame, and its gradient along rows and columns."""

NEWTON_STEPS = 4
REACH_PX = 1.0
LEAST_SLOPE = 0.25
FLATTEST = 1e-9
"""Slope of a facet below which it has no zero to go to."""
BAND, AROUND = 64, 9
MIDDLE = 4
LANE = [np.uint64(k * BAND) for k in range(3 * AROUND + 1)]
V0, V1, V2, V3, V4, V5, V6, V7, V8 = LANE[:AROUND]
"""Filtered values at the pixel and its neighbours, row by row; behind them the gradients there."""
DOWN, ACROSS = LANE[AROUND + MIDDLE], LANE[2 * AROUND + MIDDLE]
LEAST = LANE[3 * AROUND]
"""Square of the gradient below which it counts as so much."""
OUT_R, OUT_C, UNIT_R, UNIT_C, STRENGTH, FOUND = LANE[:6]
"""What is found takes the place of the values."""


@part
def gather(
    edges: Filtered, pixels: NDArray[np.intp], corner: tuple[int, int], band: Floats
) -> None:
    """Lay the surroundings of at most BAND pixels into a band."""
    for n in range(pixels.shape[0]):
        r, c, at = pixels[n, 0] - corner[0], pixels[n, 1] - corner[1], np.uint64(n)
        for i in range(3):
            for j in range(3):
                lane = at + np.uint64((3 * i + j) * BAND)
                band[lane] = edges[0][r + i - 1, c + j - 1]
                band[lane + np.uint64(AROUND * BAND)] = edges[1][r + i - 1, c + j - 1]
                band[lane + np.uint64(2 * AROUND * BAND)] = edges[2][r + i - 1, c + j - 1]


@part
def put_over_slope(band: Floats) -> None:
    """Divide the values by the gradients, none of which counts as less than LEAST_SLOPE."""
    for n in range(np.uint64(BAND)):
        square = band[DOWN + n] * band[DOWN + n] + band[ACROSS + n] * band[ACROSS + n]
        band[LEAST + n] = LEAST_SLOPE * LEAST_SLOPE * square
    for k in range(np.uint64(AROUND)):
        value = k * np.uint64(BAND)
        down, across = value + np.uint64(AROUND * BAND), value + np.uint64(2 * AROUND * BAND)
        for n in range(np.uint64(BAND)):
            square = band[down + n] * band[down + n] + band[across + n] * band[across + n]
            band[value + n] /= math.sqrt(max(square, band[LEAST + n]))


@part
def powers(before: float, middle: float, after: float) -> tuple[float, float, float]:
    """Return the coefficients of 1, t and t^2 of the parabola through three values one apart."""
    return middle, (after - before) / 2, (after + before) / 2 - middle


@part
def go_along(band: Floats) -> None:
    """Go from each pixel along its gradient to the zero of the facet."""
    for n in range(np.uint64(BAND)):
        a = powers(band[V0 + n], band[V1 + n], band[V2 + n])
        b = powers(band[V3 + n], band[V4 + n], band[V5 + n])
        c = powers(band[V6 + n], band[V7 + n], band[V8 + n])
        largest = max(abs(band[V0 + n]), abs(band[V1 + n]), abs(band[V2 + n]), 1e-12)
        largest = max(abs(band[V3 + n]), abs(band[V4 + n]), abs(band[V5 + n]), largest)
        largest = max(abs(band[V6 + n]), abs(band[V7 + n]), abs(band[V8 + n]), largest)
        one, by_c = powers(a[0], b[0], c[0]), powers(a[1], b[1], c[1])
        by_cc = powers(a[2], b[2], c[2])
        g_r, g_c = band[DOWN + n], band[ACROSS + n]
        strength = math.sqrt(g_r * g_r + g_c * g_c)
        u_r, u_c = g_r / strength, g_c / strength
        p_1 = one[1] * u_r + by_c[0] * u_c
        p_2 = one[2] * u_r * u_r + by_c[1] * u_r * u_c + by_cc[0] * u_c * u_c
        p_3 = (by_c[2] * u_r + by_cc[1] * u_c) * u_r * u_c
        p_4 = by_cc[2] * (u_r * u_c) ** 2
        along = 0.0
        for _ in range(NEWTON_STEPS):
            value = one[0] + along * (p_1 + along * (p_2 + along * (p_3 + along * p_4)))
            slope = p_1 + along * (2 * p_2 + along * (3 * p_3 + along * 4 * p_4))
            step = value / slope if abs(slope) > FLATTEST else 0.0
            along = min(max(along - step, -1.5 * REACH_PX), 1.5 * REACH_PX)
        value = one[0] + along * (p_1 + along * (p_2 + along * (p_3 + along * p_4)))
        near = abs(along) <= REACH_PX
        band[OUT_R + n], band[OUT_C + n] = along * u_r, along * u_c
        band[UNIT_R + n], band[UNIT_C + n], band[STRENGTH + n] = u_r, u_c, strength
        band[FOUND + n] = 1.0 if near & (abs(value) < 1e-3 * largest) else 0.0


@part
def add_roots(
    edges: Filtered,
    pixels: NDArray[np.intp],
    corner: tuple[int, int],
    points: Floats,
    found: NDArray[np.bool_],
) -> None:
    """Find the zeros of many pixels.

    Beside a small marker's edge the gradient may vanish; there it counts as LEAST_SLOPE of the
    middle pixel's.

    Parameters
    ----------
    pixels, corner
        Rows and columns, shape (pixels, 2), and those of the first pixel of the filtered picture.
    points
        Filled with offsets of row and column, unit normal and strength, shape (pixels, 5).
    found
        Filled with whether there is a zero, shape (pixels,).
    """
    # Lanes that are not filled hold something finite, too.
    band = np.ones((3 * AROUND + 1) * BAND)
    for first in range(0, pixels.shape[0], BAND):
        few = pixels[first : first + BAND]
        gather(edges, few, corner, band)
        put_over_slope(band)
        go_along(band)
        for n in range(few.shape[0]):
            for a in range(5):
                points[first + n, a] = band[np.uint64(a * BAND + n)]
            found[first + n] = band[FOUND + np.uint64(n)] > 0.0


@compiled
def roots_along(edges: Filtered, pixels: NDArray[np.intp], points: Floats) -> NDArray[np.bool_]:
    """Find the zeros of many pixels of a frame as `add_roots` tells; return which have one."""
    found = np.zeros(pixels.shape[0], dtype=np.bool_)
    add_roots(edges, pixels, (0, 0), points, found)
    return found
