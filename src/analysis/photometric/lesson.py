"""One view of one frame drawn for the bundle: as it is, each marker alone, and nudged."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import part
from analysis.photometric.camera import disc_of
from analysis.photometric.contour import LAYERS, add_cover
from analysis.photometric.covers import closeness, cover_canvas, into_view, paint_of, seen_from
from analysis.photometric.residual import Paint
from analysis.photometric.shading import NUDGE
from analysis.photometric.sight import Sight, Stance

Floats = NDArray[np.float64]

ALPHA, RADIUS, BLUR = 0, 1, 2
"""What is nudged, in the order of the canvases."""


class Lesson(NamedTuple):
    """What the shared unknowns are improved with.

    Attributes
    ----------
    wider
        Discs and surfaces (`sight.Look`), the blur NUDGE pixels wider.
    profiles
        Of `shading.blurred_profiles` in each view.
    tangents
        Two axes across each marker, body axes, shape (markers, 2, 3).
    limit
        Residual that counts no more, in units of the noise.
    """

    wider: tuple[Floats, Floats]
    profiles: tuple[Floats, ...]
    tangents: Floats
    limit: float


@part
def nudged_covers(
    sight: Sight,
    stance: Stance,
    view: int,
    corner: tuple[int, int],
    frame: tuple[Floats, Floats],
) -> None:
    """Draw each marker alone, and all of them with size, radius and blur nudged.

    Parameters
    ----------
    frame
        Filled: shapes (markers, rows, LAYERS, columns) and (3, rows, LAYERS, columns).
    """
    own, nudged = frame
    look = sight.look
    directions = seen_from(sight, stance, view)
    sigma = look.sigma_px[view]
    place = disc_of(sight.optics, view, stance.centre, look.radius_m)
    bigger = (place[0], place[1], place[2] * (1.0 + NUDGE))
    near = closeness(sight, stance, view)
    for m in range(directions.shape[0]):
        size = 1.0 + near * directions[m, 2]
        cap = (look.alpha * size, sigma)
        add_cover(own[m], corner, place, directions[m], cap)
        add_cover(nudged[ALPHA], corner, place, directions[m], (cap[0] + NUDGE * size, sigma))
        add_cover(nudged[RADIUS], corner, bigger, directions[m], cap)
        add_cover(nudged[BLUR], corner, place, directions[m], (cap[0], sigma + NUDGE))


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
        Of the shading (`Lesson`).
    canvas, own, covers
        Of `cover_canvas` and `nudged_covers`.
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
    own: Floats
    covers: Floats
    turns: Floats
    paint: Paint
    place: tuple[float, float, float]
    corner: tuple[int, int]
    off: tuple[float, float]


@part
def drawn_for_bundle(sight: Sight, stance: Stance, view: int, lesson: Lesson) -> Viewed:
    """Draw a view of a frame."""
    look, wider = sight.look, lesson.wider
    canvas, corner, place = cover_canvas(sight, stance, view)
    own = np.zeros((look.markers.shape[0], canvas.shape[0], LAYERS, canvas.shape[2]))
    covers = np.zeros((3, canvas.shape[0], LAYERS, canvas.shape[2]))
    nudged_covers(sight, stance, view, corner, (own, covers))
    origin = sight.optics.origins[view]
    return Viewed(
        (look.discs[view], look.surfaces[view]),
        (wider[0][view], wider[1][view]),
        lesson.profiles[view],
        canvas,
        own,
        covers,
        turns_of(sight, stance, view, lesson.tangents),
        paint_of(sight, stance, view, place[2]),
        place,
        corner,
        (place[0] - origin[0], place[1] - origin[1]),
    )
