"""The pixels' say in what all frames share: marker places, size, darkness, scales, shading."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part
from analysis.photometric.bands import BAND, LANES
from analysis.photometric.lesson import Lesson, Viewed, drawn_for_bundle
from analysis.photometric.pixel_rows import (
    BESIDE,
    SHADOW,
    WIDTH,
    add_squares,
    fill_rows,
    lay_pixels,
    pixels_of,
)
from analysis.photometric.residual import UNKNOWNS
from analysis.photometric.sight import Equations, Sight, Stance

Floats = NDArray[np.float64]
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
    patches, corners, tangents = drawn.patches, drawn.corners, drawn.turns
    among, across = sums
    side, size = patches.shape[1], among.shape[0]
    used, value = np.empty(size, np.int64), np.empty(size)
    for n in range(rows.shape[0]):
        count = 0
        for m in range(patches.shape[0]):
            i, j = pixels[0][n] - corners[m, 0], pixels[1][n] - corners[m, 1]
            if i < 0 or j < 0 or i >= side or j >= side or patches[m, i, 0, j] == 0.0:
                continue
            for t in range(2):
                change = 0.0
                for k in range(3):
                    change += patches[m, i, 3 + k, j] * tangents[m, t, k]
                used[count], value[count] = 2 * m + t, -shadows[n] * change
                count += 1
        for a in range(count):
            for b in range(a + 1):
                among[used[a], used[b]] += value[a] * value[b]
            for k in range(WIDTH):
                across[used[a], k] += value[a] * rows[n, k]


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
    sight: Sight, stance: Stance, view: int, lesson: Lesson, equations: Equations
) -> None:
    """Add one view of one frame to the equations of its own and of the shared unknowns.

    Parameters
    ----------
    equations
        Of the view's UNKNOWNS, two turns of each marker, MARKERS_SHARE and the view's own
        VIEW_SHARE.
    """
    drawn = drawn_for_bundle(sight, stance, view, lesson)
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
        fill_rows(sight.scene, drawn, lesson.limit, (lanes, wider), own)
        add_squares(own, common)
        add_turns(drawn, pixels, lanes[-BESIDE + SHADOW], own, (among, across))
    put_in_place(common, among, across, equations)
