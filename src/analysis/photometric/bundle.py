"""The pixels' say in what all frames share: marker places, size, darkness, scales.

A pixel's derivatives to the shared unknowns stand behind those to its frame's own (`residual`).
Those to the markers' size and the disc's radius and blur are differences of two renderings.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part
from analysis.photometric.lesson import ALPHA, BLUR, RADIUS, Lesson, Viewed, drawn_for_bundle
from analysis.photometric.residual import (
    LEAST_DISC,
    LOOK,
    UNKNOWNS,
    biweight,
    cover_at,
    hidden,
    lit,
    model_pixel,
    pixel_row,
    shade,
)
from analysis.photometric.shading import HARMONICS, NUDGE, ORDER, STEPS_PER_RADIUS
from analysis.photometric.shading_fit import basis
from analysis.photometric.sight import Equations, Sight, Stance

Floats = NDArray[np.float64]

MARKERS_SHARE = 3
"""Behind two turns of each marker: darkness, angular radius, log radius of the sphere they lie on.

Markers at different distances from the middle, and the same ones seen in both views, tell the
radius without the limb, whose shading may pass for another radius.
"""
VIEW_SHARE = 4 + len(HARMONICS)
"""Then of each view: log radius of the limb, blur, log of the scale at which it is placed,
stretch of the markers' places along the rows, and the shading's coefficients: what a wrong shading
would have the markers say is not to be learned."""
SCALE, STRETCH = 2, 3
"""Of these."""
SHADING = MARKERS_SHARE + 4
"""Behind the markers' turns, where the shading begins."""
BLOCK = 256
"""Pixels whose products are added at a time."""


@part
def marker_row(
    shadow: float, own: Floats, turns: Floats, row: Floats, used: NDArray[np.int64]
) -> int:
    """Fill a pixel's derivatives to turns of the markers that reach it.

    Parameters
    ----------
    shadow
        Light that full cover takes from the pixel.
    own
        Layers of each marker at the pixel, shape (markers, LAYERS).
    turns
        Tangents as turns of the view, shape (markers, 2, 3).
    row, used
        Filled: derivatives, and the indices of those that are not 0, from UNKNOWNS on.

    Returns
    -------
    The number of indices in use.
    """
    filled = UNKNOWNS
    for m in range(own.shape[0]):
        if own[m, 0] == 0.0:
            continue
        for t in range(2):
            change = 0.0
            for k in range(3):
                change += own[m, 3 + k] * turns[m, t, k]
            row[UNKNOWNS + 2 * m + t] = -shadow * change
            used[filled] = UNKNOWNS + 2 * m + t
            filled += 1
    return filled


@part
def shading_row(profiles: Floats, at: tuple[float, float], light: float, row: Floats) -> None:
    """Fill a pixel's derivatives to the coefficients of the shading, shape (harmonics,).

    Parameters
    ----------
    at
        Row and column from the centre in radii.
    light
        Gain of the light, times what the markers leave of the disc.
    """
    u, v = at
    row[:] = 0.0
    if (u * u + v * v) * STEPS_PER_RADIUS**2 < (profiles.shape[0] - 2) ** 2:
        basis(profiles, u, v, np.zeros((2, ORDER + 1)), row)
        row *= max(light, 0.0)


@part
def common_columns(
    drawn: Viewed, pixel: tuple[int, int, float, float, float], looks: Floats, row: Floats
) -> None:
    """Fill a pixel's derivatives behind the turns, those of `pixel_row` being there.

    Parameters
    ----------
    pixel
        Row and column on the canvas; row and column from the centre in radii; background.
    looks
        What is seen (`residual.shade`), and room for what is seen nudged, shape (2, LOOK).
    row
        Filled from the first derivative behind the turns.
    """
    i, j, u, v, behind = pixel
    seen, moved, paint, covers = looks[0], looks[1], drawn.paint, drawn.covers
    first = UNKNOWNS + 2 * drawn.own.shape[0]
    cover, plain, dark = cover_at(drawn.canvas, i, j), lit(seen, paint[0]), paint[1]
    model = model_pixel(seen, cover, behind, paint)
    row[first] = -plain * cover[0]
    row[first + 1] = model_pixel(seen, cover_at(covers[ALPHA], i, j), behind, paint) - model
    row[first + 2] = model_pixel(seen, cover_at(covers[RADIUS], i, j), behind, paint) - model
    shade(drawn.look[0], drawn.look[1], u / (1.0 + NUDGE), v / (1.0 + NUDGE), moved)
    row[first + 3] = model_pixel(moved, cover, behind, paint) - model
    shade(drawn.wider[0], drawn.wider[1], u, v, moved)
    row[first + 4] = model_pixel(moved, cover_at(covers[BLUR], i, j), behind, paint) - model
    for k in range(1, 5):
        row[first + k] /= NUDGE
    row[first + 5] = row[0] * drawn.off[0] + row[1] * drawn.off[1]
    row[first + 6] = -plain * dark * cover[1] * u * paint[2]
    left = 1.0 - dark * cover[0] / max(seen[0], LEAST_DISC)
    shading_row(drawn.profiles, (u, v), paint[0][1] * left, row[first + SHADING :])


@part
def add_marked(row: Floats, used: NDArray[np.int64], whitened: float, equations: Equations) -> None:
    """Add a pixel's whitened derivatives to the turns of the markers that reach it.

    Parameters
    ----------
    row
        All derivatives of the pixel.
    used
        Indices of those to turns.
    whitened
        Residual.
    """
    first = row.shape[0] - MARKERS_SHARE - VIEW_SHARE
    for a in range(used.shape[0]):
        p = used[a]
        equations.right[p] += row[p] * whitened
        for b in range(a + 1):
            equations.normal[p, used[b]] += row[p] * row[used[b]]
        for q in range(UNKNOWNS):
            equations.normal[p, q] += row[p] * row[q]
        for q in range(first, row.shape[0]):
            equations.normal[q, p] += row[p] * row[q]


@part
def add_common(block: Floats, first: int, equations: Equations) -> None:
    """Add the products of whitened derivatives but those to turns.

    Parameters
    ----------
    block
        One row for each pixel, its residual last.
    first
        Index of the first derivative behind the turns.
    """
    products, size = np.dot(block.T, block), block.shape[1] - 1
    for a in range(size):
        p = a if a < UNKNOWNS else a - UNKNOWNS + first
        equations.right[p] += products[size, a]
        for b in range(a + 1):
            q = b if b < UNKNOWNS else b - UNKNOWNS + first
            equations.normal[p, q] += products[a, b]


@compiled
def bundle_view(
    sight: Sight, stance: Stance, view: int, lesson: Lesson, equations: Equations
) -> None:
    """Add one view of one frame to the equations of its own and of the shared unknowns.

    Parameters
    ----------
    equations
        Of the view's UNKNOWNS, the markers, MARKERS_SHARE and the view's own VIEW_SHARE.
    """
    scene, look, rows = sight.scene, sight.look, sight.optics.rows[view]
    drawn = drawn_for_bundle(sight, stance, view, lesson)
    corner, place = drawn.corner, drawn.place
    first, last = UNKNOWNS + 2 * look.markers.shape[0], MARKERS_SHARE + VIEW_SHARE
    row, looks = np.zeros(first + last), np.zeros((2, LOOK))
    used, block, filled = np.arange(first), np.zeros((BLOCK, UNKNOWNS + last + 1)), 0
    for i in range(drawn.canvas.shape[0]):
        y = corner[0] + i
        if y < rows[0] or y >= rows[1]:
            continue
        u = (y - place[0]) / place[2]
        for j in range(drawn.canvas.shape[2]):
            x = corner[1] + j
            v = (x - place[1]) / place[2]
            seen = shade(drawn.look[0], drawn.look[1], u, v, looks[0])
            if not seen or hidden(y, x, sight.others[view]):
                continue
            behind = scene.background[y, x]
            residual = scene.image[y, x] - pixel_row(
                looks[0], (drawn.canvas, i, j), behind, drawn.paint, row
            )
            weight = biweight(residual / scene.noise, lesson.limit)
            if weight == 0.0:
                continue
            shadow = lit(looks[0], drawn.paint[0]) * look.darkness
            marked = marker_row(shadow, drawn.own[:, i, :, j], drawn.turns, row, used)
            common_columns(drawn, (i, j, u, v, behind), looks, row)
            row *= math.sqrt(weight) / scene.noise
            whitened = residual * math.sqrt(weight) / scene.noise
            add_marked(row, used[UNKNOWNS:marked], whitened, equations)
            if filled == BLOCK:
                add_common(block, first, equations)
                filled = 0
            block[filled, :UNKNOWNS], block[filled, UNKNOWNS:-1] = row[:UNKNOWNS], row[first:]
            block[filled, -1] = whitened
            filled += 1
    add_common(block[:filled], first, equations)
