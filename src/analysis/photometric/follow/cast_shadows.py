"""Shadows cast on a sphere: pixels without information on its pose.

Spheres near each other shadow each other, and so do mirrors and tubes. What lies deep in a shadow
is an outlier and counts nothing anyway. Along the limb, though, the outer pixels, of which the
sphere fills a little, miss no more light than their noise, and draw the disc inwards. So a shadow
is taken out with what surrounds it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.photometric.render.accumulation import lay_outer_instants, resolve, span_along
from analysis.photometric.render.bands import (
    BAND,
    DISC,
    LANES,
    RESIDUAL,
    ROOT,
    ground_of,
    lay_piece,
)
from analysis.photometric.render.covers import cover_canvases, paint_of
from analysis.photometric.render.residual import LEAST_DISC
from analysis.photometric.render.sight import Reel, Sight, Stance, sight_at

Places = NDArray[np.int64]
Mask = NDArray[np.bool_]

DEEP, SHALLOW = 3.0, 1.0
"""Missing light, mean of 3 x 3 pixels over the noise of one: somewhere in a shadow at least the
first, everywhere in it at least the second."""
LEAST_MARKERS = 0.3
"""Area of a shadow at least, in those of a marker: less is a marker that is held a little beside
its place. A marker that is not known is taken out like a shadow."""
MARGIN_PX = 3
"""Around a shadow: the blur of its border and of the limb."""


@part
def missing_light(sight: Sight, stance: Stance, view: int) -> tuple[Floats, tuple[int, int], float]:
    """Return by how much each pixel of a disc is darker than rendered, over the noise.

    Returns
    -------
    Shape (rows, columns), less where markers are and 0 where the sphere is not seen; row and column
    of its first pixel; radius of the disc, pixels.
    """
    canvases, corner, places = cover_canvases(sight, stance, view)
    canvas, place = canvases[0], (places[0, 0], places[0, 1], places[0, 2])
    missing = np.zeros((canvas.shape[0], canvas.shape[2]))
    bands = np.empty((places.shape[0], LANES * BAND))
    band = bands[0]
    rows, darkness, noise = sight.optics.rows[view], sight.look.darkness, sight.scene.noise
    seen = (sight.look.discs[view], sight.look.surfaces[view])
    paint, ground = paint_of(sight, stance, view, place[2]), ground_of(sight, view)
    # What takes a literal 0 would be compiled for it and once more for other numbers.
    none: int = 0 * rows[0]
    for i in range(max(rows[0] - corner[0], 0), min(canvas.shape[0], rows[1] - corner[0])):
        start, end = span_along(corner[0] + i, place, 1.0, (corner[1], canvas.shape[2]))
        while start < end:
            width = min(end - start, BAND)
            y, x = corner[0] + i, corner[1] + start
            covers = canvas[i, :, start : start + width]
            lay_piece(ground, covers, (y, x, place), (band, none, width))
            lay_outer_instants(ground, (canvases, places), (y, x, corner), (bands, none, width))
            resolve(seen, paint, bands, width)
            for n in range(np.uint64(width)):
                left = max(1.0 - darkness * covers[0, n] / max(band[DISC + n], LEAST_DISC), 0.0)
                counts = 1.0 if band[ROOT + n] > 0.0 else 0.0
                missing[i, start + n] = -band[RESIDUAL + n] / noise * left * left * counts
            start += width
    return missing, corner, place[2]


@part
def box_mean(values: Floats) -> Floats:
    """Return the mean of each 3 x 3 values, 0 at the border."""
    mean = np.zeros(values.shape)
    for i in range(1, values.shape[0] - 1):
        for j in range(1, values.shape[1] - 1):
            total = 0.0
            for a in range(i - 1, i + 2):
                total += values[a, j - 1] + values[a, j] + values[a, j + 1]
            mean[i, j] = total / 9.0
    return mean


@part
def flood(mean: Floats, start: tuple[int, int], taken: Mask, places: Places) -> int:
    """Find the connected places from a start on that are at least SHALLOW; return how many.

    Parameters
    ----------
    taken
        Places found before, added to.
    places
        Filled with row and column of each, shape (as many as `mean` has, 2).
    """
    places[0, 0], places[0, 1] = start
    taken[start] = True
    done, found = 0, 1
    while done < found:
        row, column = places[done]
        done += 1
        for i in range(max(row - 1, 0), min(row + 2, mean.shape[0])):
            for j in range(max(column - 1, 0), min(column + 2, mean.shape[1])):
                if mean[i, j] >= SHALLOW and not taken[i, j]:
                    taken[i, j] = True
                    places[found, 0], places[found, 1] = i, j
                    found += 1
    return found


@part
def spread(row: int, column: int, rows: Places, shadowed: Mask) -> None:
    """Mark a pixel and its margin, within the rows of a view."""
    first = max(column - MARGIN_PX, 0)
    last = min(column + MARGIN_PX + 1, shadowed.shape[1])
    for i in range(max(row - MARGIN_PX, rows[0], 0), min(row + MARGIN_PX + 1, rows[1])):
        for j in range(first, last):
            shadowed[i, j] = True


@part
def mark_view(sight: Sight, stance: Stance, view: int) -> None:
    """Mark the shadows on a sphere in one view, and their margins, in the scene's own mask."""
    missing, corner, radius = missing_light(sight, stance, view)
    mean, rows = box_mean(missing), sight.optics.rows[view]
    if mean.size == 0 or mean.max() < DEEP:
        return
    taken, places = np.zeros(mean.shape, np.bool_), np.empty((mean.size, 2), np.int64)
    least = LEAST_MARKERS * math.pi * (sight.look.alpha * radius) ** 2
    for i in range(mean.shape[0]):
        for j in range(mean.shape[1]):
            if mean[i, j] < DEEP or taken[i, j]:
                continue
            found = flood(mean, (i, j), taken, places)
            if found < least:
                continue
            for n in range(found):
                row, column = corner[0] + places[n, 0], corner[1] + places[n, 1]
                spread(row, column, rows, sight.scene.shadowed)


@compiled
def mark_shadows(reel: Reel, frames: NDArray[np.intp]) -> None:
    """Mark the shadows on a sphere in some frames of a reel, and their margins, in its masks."""
    for k in frames:
        sight, stance = sight_at(reel, k)
        for view in range(reel.optics.scales.shape[0]):
            mark_view(sight, stance, view)
