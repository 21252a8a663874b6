"""Markers that a first look has missed: dark places of the body that no known marker explains."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.render.covers import cover_canvas, into_view, paint_of
from analysis.photometric.render.residual import LOOK, cover_at, covered, model_pixel, shade
from analysis.photometric.render.sight import Look, Sight, Stance

DIRECTIONS = 2000
LEAST_FACING = 0.35
LEAST_FRAMES = 3
LEAST_DARKNESS = 0.45
"""Of a known marker's: half of a pixel's cover, seen over several frames."""
RING, WIDE = 1.4, 2.2
"""Angular radii of a marker between which its surroundings lie."""
APART = 1.9
"""Angular radii between markers: two caps that touch are 2 apart."""
MOST_NEW = 8


def body_directions() -> Floats:
    """Return directions spread evenly over the sphere, shape (DIRECTIONS, 3)."""
    k = np.arange(DIRECTIONS) + 0.5
    z = 1 - 2 * k / DIRECTIONS
    turn = np.pi * (1 + np.sqrt(5.0)) * k
    flat = np.sqrt(1 - z**2)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


@compiled
def add_darkness(
    sight: Sight, stance: Stance, view: int, body: Floats, places: tuple[Floats, Floats]
) -> None:
    """Add the unexplained darkness of one view of one frame to each direction that it shows.

    Parameters
    ----------
    body
        Directions in body axes, shape (directions, 3).
    places
        Sums and counts, added to, shapes (directions,).
    """
    sums, counts = places
    scene, look = sight.scene, sight.look
    canvas, corner, place = cover_canvas(sight, stance, view)
    light, rows = stance.lights[view], sight.optics.rows[view]
    paint = paint_of(sight, stance, view, place[2])
    into, seen = into_view(sight, stance, view), np.zeros(LOOK)
    for n in range(body.shape[0]):
        if turned_to(into[2], body[n]) < LEAST_FACING:
            continue
        y = int(np.rint(place[0] + place[2] * turned_to(into[0], body[n])))
        x = int(np.rint(place[1] + place[2] * turned_to(into[1], body[n])))
        i, j = y - corner[0], x - corner[1]
        if i < 0 or j < 0 or i >= canvas.shape[0] or j >= canvas.shape[2]:
            continue
        if y < rows[0] or y >= rows[1] or covered(y, x, sight.others[view]):
            continue
        u, v = (y - place[0]) / place[2], (x - place[1]) / place[2]
        shade(look.discs[view], look.surfaces[view], u, v, seen)
        model = model_pixel(seen, cover_at(canvas, i, j), scene.background[y, x], paint)
        plain = max(light[1] * seen[3] * seen[0], 3.0 * scene.noise)
        sums[n] += min(max((model - scene.image[y, x]) / plain, -1.0), 1.0)
        counts[n] += 1.0


@part
def turned_to(axis: Floats, direction: Floats) -> float:
    """Return the part of a direction along an axis."""
    return float(axis[0] * direction[0] + axis[1] * direction[1] + axis[2] * direction[2])


def missed_markers(
    sights: Iterable[tuple[Sight, Stance]], known: Appearance, sphere: int
) -> Floats:
    """Return markers of a sphere that its frames show and its look lacks, body axes, (new, 3)."""
    body = body_directions()
    sums, counts = np.zeros(len(body)), np.zeros(len(body))
    look = known.looks()[sphere]
    for sight, stance in sights:
        for view in range(len(known.camera.views)):
            add_darkness(sight, stance, view, body, (sums, counts))
    often = counts >= LEAST_FRAMES
    darkness = np.where(often, sums / np.maximum(counts, 1.0), 0.0)
    return _peaks(body, darkness, often, look)


@compiled
def local_darkness(
    body: Floats, darkness: Floats, often: NDArray[np.bool_], alpha: float, least: float
) -> Floats:
    """Return by how much a cap about each direction is darker than the ring around it.

    The ring reaches from RING to WIDE angular radii of a marker. A shadow is as dark as what
    surrounds it. 0 where the direction is not seen.

    Parameters
    ----------
    body
        Of `body_directions`: their third coordinate falls.
    least
        Caps less dark than this are not held against their rings, which cannot make them darker.
    """
    local, first = np.zeros(body.shape[0]), 0
    inside, ring, wide = math.cos(alpha), math.cos(RING * alpha), math.cos(WIDE * alpha)
    # The third coordinate falls by as much from each direction to the next.
    near = math.ceil(alpha * body.shape[0] / 2) + 1
    for n in range(body.shape[0]):
        while body[first, 2] - body[n, 2] > WIDE * alpha:
            first += 1
        if not often[n]:
            continue
        total, count = 0.0, 0
        for k in range(max(n - near, 0), min(n + near + 1, body.shape[0])):
            if often[k] and turned_to(body[n], body[k]) > inside:
                total += darkness[k]
                count += 1
        local[n] = total / count
        if local[n] < least:
            continue
        around, beside, k = 0.0, 0, first
        while k < body.shape[0] and body[n, 2] - body[k, 2] <= WIDE * alpha:
            if often[k] and wide < turned_to(body[n], body[k]) < ring:
                around += darkness[k]
                beside += 1
            k += 1
        local[n] -= max(around / max(beside, 1), 0.0)
    return local


def _peaks(body: Floats, darkness: Floats, often: NDArray[np.bool_], look: Look) -> Floats:
    """Take the darkest caps one after another, away from the known markers and each other."""
    known = list(look.markers)
    found: list[Floats] = []
    least = LEAST_DARKNESS * look.darkness
    cap = local_darkness(body, darkness, often, float(look.alpha), float(least))
    free = np.ones(len(body), dtype=np.bool_)
    if known:
        free &= (body @ np.array(known).T < np.cos(APART * look.alpha)).all(axis=1)
    for _ in range(MOST_NEW):
        best = int(np.where(free, cap, 0.0).argmax())
        if not free[best] or cap[best] < least:
            break
        around = (body @ body[best] > np.cos(look.alpha)) & often
        direction = (np.maximum(darkness[around], 0.0)[:, None] * body[around]).sum(axis=0)
        direction /= np.linalg.norm(direction)
        found.append(direction)
        free &= body @ direction < np.cos(APART * look.alpha)
    return np.array(found).reshape(-1, 3)
