"""A view of a frame to its normal equations: all pixels of a sphere, over the whole exposure.

The pixels lie in bands (`bands`), one for each instant; their mean is the exposure.
"""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import part
from analysis.photometric.render.bands import (
    BAND,
    LANES,
    Ground,
    add_products,
    derive,
    ground_of,
    lay_piece,
    look_up,
    weigh,
)
from analysis.photometric.render.covers import cover_canvases, paint_of
from analysis.photometric.render.residual import UNKNOWNS, Paint
from analysis.photometric.render.sight import Equations, Sight, Stance
from analysis.photometric.render.smear import MIDDLE
from analysis.photometric.render.surface import SQUARE_STEPS


@part
def resolve(seen: tuple[Floats, Floats], paint: Paint, bands: Floats, count: int) -> None:
    """Fill residuals and derivatives of a band: the mean of those at its instants (`smear`).

    Parameters
    ----------
    seen
        Disc and surface of the view (`sight.Look`).
    bands
        Of each instant, the middle one's first, which is filled; shape (instants, LANES BAND).
    """
    for n in range(bands.shape[0]):
        look_up(seen[0], seen[1], bands[n], count)
        derive(paint, bands[n], count)
    if bands.shape[0] == 1:
        return
    whole, before, after = bands[0], bands[1], bands[2]
    for lane in range(UNKNOWNS + 1):
        first = np.uint64(lane * BAND)
        for n in range(np.uint64(count)):
            outer = 0.5 * (1.0 - MIDDLE) * (before[first + n] + after[first + n])
            whole[first + n] = MIDDLE * whole[first + n] + outer


@part
def settle(
    seen: tuple[Floats, Floats],
    paint: Paint,
    filled: tuple[Floats, int],
    spread: tuple[float, float],
    equations: Equations,
) -> tuple[float, float]:
    """Add a filled band to the normal equations; return what `weigh` returns.

    Parameters
    ----------
    seen
        As for `resolve`.
    filled
        The bands and their number of pixels.
    spread
        As for `weigh`.
    """
    bands, count = filled
    resolve(seen, paint, bands, count)
    sums = weigh(bands[0], count, spread)
    add_products(bands[0], count, equations)
    return sums


@part
def accumulate(
    sight: Sight, stance: Stance, view: int, limit: float, equations: Equations
) -> tuple[float, float, int]:
    """Add one view of one sphere to its normal equations.

    Parameters
    ----------
    limit
        Residual from which a pixel counts no more, in units of the noise.
    equations
        Of the view's UNKNOWNS.

    Returns
    -------
    Weighted sum of squares over the noise's variance, sum of weights, pixels looked at.
    """
    scene, disc, surface = sight.scene, sight.look.discs[view], sight.look.surfaces[view]
    canvases, corner, places = cover_canvases(sight, stance, view)
    rows, place = sight.optics.rows[view], (places[0, 0], places[0, 1], places[0, 2])
    reach2, ground = reach_of(disc, places), ground_of(sight, view)
    seen, paint = (disc, surface), paint_of(sight, stance, view, place[2])
    bands, widest = np.empty((places.shape[0], LANES * BAND)), limit * scene.noise
    canvas, band, smeared = canvases[0], bands[0], places.shape[0] > 1
    # What takes a literal 0 would be compiled for it and once more for other numbers.
    none: int = 0 * rows[0]
    squares, weights, count, filled = 0.0, 0.0, 0, none
    first_row = max(rows[0] - corner[0], 0)
    for i in range(first_row, min(canvases.shape[1], rows[1] - corner[0])):
        start, end = span_along(corner[0] + i, place, reach2, (corner[1], canvases.shape[3]))
        while start < end:
            width = min(end - start, BAND)
            if filled + width > BAND:
                part = settle(seen, paint, (bands, filled), (scene.noise, widest), equations)
                squares, weights, filled = squares + part[0], weights + part[1], none
            y, x = corner[0] + i, corner[1] + start
            covers = canvas[i, :, start : start + width]
            count += lay_piece(ground, covers, (y, x, place), (band, filled, width))
            if smeared:
                at = (y, x, corner)
                lay_outer_instants(ground, (canvases, places), at, (bands, filled, width))
            filled += width
            start += width
    part = settle(seen, paint, (bands, filled), (scene.noise, widest), equations)
    return (squares + part[0]) * limit * limit, weights + part[1], count


@part
def span_along(
    row: int, place: tuple[float, float, float], reach2: float, columns: tuple[int, int]
) -> tuple[int, int]:
    """Return the half-open columns of a canvas that a disc reaches in a row of the frame.

    Parameters
    ----------
    place
        Row, column and radius of the disc.
    reach2
        Square of the distance that it reaches, in radii.
    columns
        The canvas's first, and its number.
    """
    u = (row - place[0]) / place[2]
    if u * u >= reach2:
        return 0, 0
    half, middle = math.sqrt(reach2 - u * u) * place[2], place[1] - columns[0]
    return max(math.ceil(middle - half), 0), min(math.floor(middle + half) + 1, columns[1])


@part
def reach_of(disc: Floats, places: Floats) -> float:
    """Return the square of the distance, in radii, that a disc reaches from its middle instant."""
    reach2: float = (disc.shape[0] - 1) / SQUARE_STEPS
    if places.shape[0] == 1:
        return reach2
    off = math.hypot(places[2, 0] - places[0, 0], places[2, 1] - places[0, 1])
    return float((math.sqrt(reach2) + off / places[0, 2]) ** 2)


@part
def lay_outer_instants(
    ground: Ground,
    drawn: tuple[Floats, Floats],
    at: tuple[int, int, tuple[int, int]],
    piece: tuple[Floats, int, int],
) -> None:
    """Lay pixels of one row of a frame into the bands of all instants but the middle one.

    Parameters
    ----------
    ground
        Of `bands.ground_of`.
    drawn
        Canvases and places (`covers.cover_canvases`).
    at
        Row and column of the first pixel, and those of the canvases' first.
    piece
        The bands, where the row starts in them, and its number of pixels.
    """
    (canvases, places), (y, x, corner), (bands, filled, width) = drawn, at, piece
    i, start = y - corner[0], x - corner[1]
    for n in range(1, places.shape[0]):
        covers = canvases[n, i, :, start : start + width]
        place = (places[n, 0], places[n, 1], places[n, 2])
        lay_piece(ground, covers, (y, x, place), (bands[n], filled, width))
