"""The pixels' say in what all frames share: marker places, size, darkness, scales.

A pixel's derivatives to the shared unknowns stand behind those to its frame's own (`residual`).
Those to the markers' size and the disc's radius and blur are differences of two renderings.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part
from analysis.photometric.camera import disc_of
from analysis.photometric.contour import LAYERS, add_cover
from analysis.photometric.covers import closeness, cover_canvas, into_view, paint_of, seen_from
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
ALPHA, RADIUS, BLUR = 0, 1, 2


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
def add_row(
    row: Floats,
    used: NDArray[np.int64],
    seen: tuple[float, float, float],
    equations: Equations,
) -> None:
    """Add a pixel's derivatives to the equations.

    Parameters
    ----------
    used
        Indices of those that are not 0.
    seen
        Weight over the noise, residual over the noise, noise.
    """
    weight, residual, noise = seen
    for a in range(used.shape[0]):
        p = used[a]
        scaled = weight * row[p]
        equations.right[p] += scaled * residual
        scaled /= noise
        for b in range(a + 1):
            equations.normal[p, used[b]] += scaled * row[used[b]]


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
    scene, look = sight.scene, sight.look
    disc, surface = look.discs[view], look.surfaces[view]
    wider, wider_surface = lesson.wider[0][view], lesson.wider[1][view]
    canvas, corner, place = cover_canvas(sight, stance, view)
    light, rows = stance.lights[view], sight.optics.rows[view]
    paint = paint_of(sight, stance, view, place[2])
    count = look.markers.shape[0]
    own = np.zeros((count, canvas.shape[0], LAYERS, canvas.shape[2]))
    covers = np.zeros((3, canvas.shape[0], LAYERS, canvas.shape[2]))
    nudged_covers(sight, stance, view, corner, (own, covers))
    turns = turns_of(sight, stance, view, lesson.tangents)
    off = place[0] - sight.optics.origins[view, 0], place[1] - sight.optics.origins[view, 1]
    first, last = UNKNOWNS + 2 * count, MARKERS_SHARE + VIEW_SHARE
    row, seen, moved = np.zeros(first + last), np.zeros(LOOK), np.zeros(LOOK)
    used = np.arange(first + last)
    for i in range(canvas.shape[0]):
        y = corner[0] + i
        if y < rows[0] or y >= rows[1]:
            continue
        u = (y - place[0]) / place[2]
        for j in range(canvas.shape[2]):
            x = corner[1] + j
            v = (x - place[1]) / place[2]
            if not shade(disc, surface, u, v, seen) or hidden(y, x, sight.others[view]):
                continue
            behind, dark = scene.background[y, x], look.darkness
            model = pixel_row(seen, (canvas, i, j), behind, paint, row)
            residual = (scene.image[y, x] - model) / scene.noise
            weight = biweight(residual, lesson.limit) / scene.noise
            if weight == 0.0:
                continue
            plain = lit(seen, light)
            filled = marker_row(plain * dark, own[:, i, :, j], turns, row, used)
            row[first] = -plain * canvas[i, 0, j]
            there = model_pixel(seen, cover_at(covers[ALPHA], i, j), behind, paint)
            row[first + 1] = (there - model) / NUDGE
            there = model_pixel(seen, cover_at(covers[RADIUS], i, j), behind, paint)
            row[first + 2] = (there - model) / NUDGE
            shade(disc, surface, u / (1.0 + NUDGE), v / (1.0 + NUDGE), moved)
            there = model_pixel(moved, cover_at(canvas, i, j), behind, paint)
            row[first + 3] = (there - model) / NUDGE
            shade(wider, wider_surface, u, v, moved)
            there = model_pixel(moved, cover_at(covers[BLUR], i, j), behind, paint)
            row[first + 4] = (there - model) / NUDGE
            row[first + 5] = row[0] * off[0] + row[1] * off[1]
            row[first + 6] = -plain * dark * canvas[i, 1, j] * (y - place[0])
            left = 1.0 - dark * canvas[i, 0, j] / max(seen[0], LEAST_DISC)
            shading_row(lesson.profiles[view], (u, v), light[1] * left, row[first + SHADING :])
            for k in range(last):
                used[filled + k] = first + k
            add_row(row, used[: filled + last], (weight, residual, scene.noise), equations)
