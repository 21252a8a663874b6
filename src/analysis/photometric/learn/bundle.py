"""Normal equations of what all frames share: marker places, size, darkness, scales, shading."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.photometric.learn.training_view import TrainingView, Viewed, drawn_for_bundle
from analysis.photometric.render.bands import BAND, LANES
from analysis.photometric.render.pixel_rows import (
    BESIDE,
    SHADOW,
    WIDTH,
    add_squares,
    fill_rows,
    lay_pixels,
    pixels_of,
)
from analysis.photometric.render.residual import UNKNOWNS
from analysis.photometric.render.sight import Equations, Sight, Stance

Places = NDArray[np.int64]


@part
def add_turns(
    drawn: Viewed,
    pixels: tuple[Places, Places],
    shadows: Floats,
    rows: Floats,
    sums: tuple[Floats, Floats],
) -> None:
    """Add products of the derivatives to turns of the markers, which few pixels see.

    Parameters
    ----------
    shadows
        Light that full cover takes from each pixel, over its error.
    sums
        Products with each other, shape (turns, turns), and with the rows, shape (turns, WIDTH).
    """
    corners, side, count = drawn.corners, drawn.patches.shape[1], rows.shape[0]
    changes, used = np.zeros((corners.shape[0], 2, count)), np.empty(count, np.int64)
    for m in range(corners.shape[0]):
        if corners[m, 0] > pixels[0][count - 1] or corners[m, 0] + side <= pixels[0][0]:
            continue
        found = turn_one(drawn, pixels, m, used, changes[m])
        for n in used[:found]:
            add_two(changes[m, :, n], rows[n], shadows[n], sums[1][2 * m : 2 * m + 2])
        for other in range(m + 1):
            if abs(corners[m, 0] - corners[other, 0]) >= side:
                continue
            for n in used[:found]:
                square = shadows[n] * shadows[n]
                for a in range(2):
                    for b in range(2):
                        product = square * changes[m, a, n] * changes[other, b, n]
                        sums[0][2 * m + a, 2 * other + b] += product


@part
def turn_one(
    drawn: Viewed, pixels: tuple[Places, Places], m: int, used: Places, changes: Floats
) -> int:
    """Find the pixels that see a marker, and how each of its two turns changes them.

    Parameters
    ----------
    used
        Filled with the indices of those pixels; how many is returned.
    changes
        Filled there, shape (2, pixels).
    """
    patch, tangents, side, found = drawn.patches[m], drawn.turns[m], drawn.patches.shape[1], 0
    for n in range(pixels[0].size):
        i, j = pixels[0][n] - drawn.corners[m, 0], pixels[1][n] - drawn.corners[m, 1]
        if i < 0 or j < 0 or i >= side or j >= side or patch[i, 0, j] == 0.0:
            continue
        for t in range(2):
            for k in range(3):
                changes[t, n] -= patch[i, 3 + k, j] * tangents[t, k]
        used[found] = n
        found += 1
    return found


@part
def add_two(changes: Floats, row: Floats, shadow: float, across: Floats) -> None:
    """Add a pixel's row times its changes by two turns."""
    first, second = shadow * changes[0], shadow * changes[1]
    for k in range(np.uint64(WIDTH)):
        across[0, k] += first * row[k]
        across[1, k] += second * row[k]


@part
def put_in_place(common: Floats, among: Floats, across: Floats, equations: Equations) -> None:
    """Add products to the equations, where the turns stand behind the frame's own unknowns.

    Parameters
    ----------
    common
        Of the rows with each other, shape (WIDTH, WIDTH).
    among, across
        Of `add_turns`.
    """
    turns, normal, right = among.shape[0], equations.normal, equations.right
    for a in range(WIDTH - 1):
        p = a if a < UNKNOWNS else a + turns
        right[p] += common[WIDTH - 1, a]
        for b in range(a + 1):
            normal[p, b if b < UNKNOWNS else b + turns] += common[a, b]
    for a in range(turns):
        p = UNKNOWNS + a
        right[p] += across[a, WIDTH - 1]
        for b in range(a + 1):
            normal[p, UNKNOWNS + b] += among[a, b]
        for b in range(UNKNOWNS):
            normal[p, b] += across[a, b]
        for b in range(UNKNOWNS, WIDTH - 1):
            normal[b + turns, p] += across[a, b]


@compiled
def bundle_view(
    sight: Sight, stance: Stance, view: int, training: TrainingView, equations: Equations
) -> None:
    """Add one view of one frame to the equations of its own and of the shared unknowns.

    Parameters
    ----------
    equations
        Of the view's UNKNOWNS, two turns of each marker, MARKERS_SHARE and the view's own
        VIEW_SHARE.
    """
    drawn = drawn_for_bundle(sight, stance, view, training)
    y, x = pixels_of(drawn, sight.optics.rows[view])
    turns = 2 * sight.look.markers.shape[0]
    common, among, across = (
        np.zeros((WIDTH, WIDTH)),
        np.zeros((turns, turns)),
        np.zeros((turns, WIDTH)),
    )
    lanes, wider, rows = (
        np.zeros((LANES + BESIDE, BAND)),
        np.zeros(LANES * BAND),
        np.zeros((BAND, WIDTH)),
    )
    for first in range(0, y.shape[0], BAND):
        pixels = y[first : first + BAND], x[first : first + BAND]
        own = rows[: pixels[0].shape[0]]
        lay_pixels(sight.scene, drawn, sight.others[view], pixels, lanes)
        fill_rows(sight.scene, drawn, training.limit, (lanes, wider), own)
        add_squares(own, common)
        add_turns(drawn, pixels, lanes[-BESIDE + SHADOW], own, (among, across))
    put_in_place(common, among, across, equations)
