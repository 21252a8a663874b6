"""One view of one frame drawn for the bundle: each marker alone, and all together."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import part
from analysis.photometric.render.camera import disc_of
from analysis.photometric.render.contour import (
    ALPHA,
    GROWTHS,
    LAYERS,
    REACH_SIGMAS,
    add_cover,
    faces,
)
from analysis.photometric.render.covers import closeness, into_view, paint_of, seen_from, window
from analysis.photometric.render.residual import Paint
from analysis.photometric.render.sight import Sight, Stance

HALF_TURN = math.pi / 2
NOWHERE = -(1 << 30)
"""Row and column of a patch that is not drawn."""


class TrainingView(NamedTuple):
    """What the shared unknowns are improved with.

    Attributes
    ----------
    wider
        Discs and surfaces (`sight.Look`), the blur NUDGE pixels wider.
    profiles
        Of `appearance.profiles_of`, shape (V, steps, radials).
    tangents
        Two axes across each marker, body axes, shape (markers, 2, 3).
    limit
        Residual that counts no more, in units of the noise.
    inside
        Weight of these pixels in the fit of the shading, where a relief takes the rest.
    """

    wider: tuple[Floats, Floats]
    profiles: Floats
    tangents: Floats
    limit: float
    inside: float = 1.0


@part
def patches_of(
    sight: Sight, stance: Stance, view: int, place: tuple[float, float, float]
) -> tuple[Floats, NDArray[np.int64]]:
    """Draw each marker alone, into a patch just large enough for the largest.

    Returns
    -------
    Patches, shape (markers, side, LAYERS + GROWTHS, side), and the rows and columns of their first
    pixels in the frame, shape (markers, 2): NOWHERE for those that are hidden.
    """
    look, near = sight.look, closeness(sight, stance, view)
    directions, sigma = seen_from(sight, stance, view), look.sigma_px[view]
    reach = place[2] * math.sin(min(look.alpha * (1.0 + near), HALF_TURN)) + REACH_SIGMAS * sigma
    side, count = 2 * math.ceil(reach) + 2, directions.shape[0]
    patches = np.empty((count, side, LAYERS + GROWTHS, side))
    corners = np.full((count, 2), NOWHERE)
    for m in range(count):
        size = 1.0 + near * directions[m, 2]
        if not faces(directions[m], look.alpha * size):
            continue
        for k in range(2):
            middle = place[k] + place[2] * directions[m, k] * math.cos(look.alpha * size)
            corners[m, k] = math.floor(middle) - side // 2 + 1
        patches[m] = 0.0
        corner = (corners[m, 0], corners[m, 1])
        add_cover(patches[m], corner, place, directions[m], (look.alpha * size, sigma))
        for i in range(side if near > 0.0 else 0):
            for j in range(side):
                patches[m, i, ALPHA, j] *= size
    return patches, corners


@part
def put_together(
    patches: Floats, corners: NDArray[np.int64], corner: tuple[int, int], canvas: Floats
) -> None:
    """Add all patches to a canvas, shape (rows, LAYERS + GROWTHS, columns)."""
    rows, layers, columns = canvas.shape
    side = patches.shape[1]
    for m in range(patches.shape[0]):
        if corners[m, 0] == NOWHERE:
            continue
        down, across = corners[m, 0] - corner[0], corners[m, 1] - corner[1]
        first, last = max(0, -across), min(side, columns - across)
        for i in range(max(0, -down), min(side, rows - down)):
            for layer in range(layers if first < last else 0):
                own = patches[m, i, layer, first:last]
                under = canvas[down + i, layer, across + first : across + last]
                for j in range(own.size):
                    under[j] += own[j]


@part
def turns_of(sight: Sight, stance: Stance, view: int, tangents: Floats) -> Floats:
    """Return the markers' tangents as turns of a view, shape (markers, 2, 3)."""
    into, turns = into_view(sight, stance, view), np.zeros(tangents.shape)
    for m in range(tangents.shape[0]):
        for t in range(2):
            for a in range(3):
                for k in range(3):
                    turns[m, t, a] += into[a, k] * tangents[m, t, k]
                turns[m, t, a] *= sight.optics.hands[view]
    return turns


class Viewed(NamedTuple):
    """One view of one frame, drawn for the bundle.

    Attributes
    ----------
    look, wider
        Disc and surface, and the same with the blur NUDGE wider.
    profiles
        Of the shading (`TrainingView`).
    canvas
        All markers, shape (rows, LAYERS + GROWTHS, columns).
    patches, corners
        Of `patches_of`.
    turns
        Of `turns_of`.
    paint
        Of `paint_of`.
    place
        Row, column and radius of the disc, pixels.
    corner
        Row and column of the canvas's first pixel.
    off
        Row and column of the disc from the rig's origin, pixels.
    """

    look: tuple[Floats, Floats]
    wider: tuple[Floats, Floats]
    profiles: Floats
    canvas: Floats
    patches: Floats
    corners: NDArray[np.int64]
    turns: Floats
    paint: Paint
    place: tuple[float, float, float]
    corner: tuple[int, int]
    off: tuple[float, float]


@part
def drawn_for_bundle(sight: Sight, stance: Stance, view: int, training: TrainingView) -> Viewed:
    """Draw a view of a frame."""
    look, wider = sight.look, training.wider
    place = disc_of(sight.optics, view, stance.centre, look.radius_m)
    shape = (sight.scene.image.shape[0], sight.scene.image.shape[1])
    first_r, last_r, first_c, last_c = window(place, shape)
    canvas = np.zeros((last_r - first_r, LAYERS + GROWTHS, last_c - first_c))
    patches, corners = patches_of(sight, stance, view, place)
    put_together(patches, corners, (first_r, first_c), canvas)
    origin = sight.optics.origins[view]
    return Viewed(
        (look.discs[view], look.surfaces[view]),
        (wider[0][view], wider[1][view]),
        training.profiles[view],
        canvas,
        patches,
        corners,
        turns_of(sight, stance, view, training.tangents),
        paint_of(sight, stance, view, place[2]),
        place,
        (first_r, first_c),
        (place[0] - origin[0], place[1] - origin[1]),
    )
