"""Discs followed through a film: edges, predicted places and outlines of all frames at once."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.compiled import compiled, part
from analysis.imaging.discs import peaks_near
from analysis.imaging.edge.windows import Filters, Integers, edges_about
from analysis.imaging.limb import LIMB_REACH_PX, Edges, settle_outlines

Indices = NDArray[np.intp]
FilmCurves = tuple[Floats, Integers, Indices]
"""Edge points of a film: rows, columns, unit normals and strengths, shape (5, room); the label of
each, shape (room,); and where those of each frame begin and end, shape (frames, 2)."""
Outlines = tuple[Floats, Floats, Floats, Floats, Indices]
"""Of several discs: circles, covariances, coverages, accepted points and where they begin and end,
as in `film_discs.FilmDiscs` with one axis of discs."""
Rules = tuple[tuple[float, bool], float]
"""Limits of `limb.settle_outlines`, and the share of its limb that an outline shows. The limits
come from outside: a truth value written here would be a kind of its own to the compiler."""
Look = tuple[Floats, Floats, Floats, Floats, Indices]
"""Of one frame: circles, covariances, coverages, negative where none holds, accepted points, shape
(points, 2), and the number up to the end of each disc."""

T = TypeVar("T", bound=np.generic)

MOST_MISSES = 3
REACH = 0.35
"""A disc is looked for within this many radii of where its motion predicts it."""
CLOSE_PX = 1.5
"""So near to its place by two frames before is a disc in free flight; at the contact it is not."""
FAR = 3.0
"""A disc whose motion is not known yet is looked for within this many radii in the end."""
STEPS = 2
REVERSAL = 4.0
"""A light sphere may come back from a heavy one faster than it came: of like speeds its own changes
by less than four times as much. It is looked for within so many of its steps since it was last
seen."""
APART = 0.6
"""Of both radii together: nearer to a disc that was found, a far place is that disc again."""
MOST_GROWTH = 0.15
"""An outline's radius differs from the expected one by less than this share."""
LEAST_RIM_SHARE = 0.1
"""A peak of the votes with less of a rim is no disc."""


@part
def with_room(pool: NDArray[T], size: int, more: int, frames: int) -> NDArray[T]:
    """Return a pool, shape (fields, room), that takes more after the first `size`.

    Where it has to be a wider one, it takes as many again and again, once for each frame.
    """
    if size + more <= pool.shape[1]:
        return pool
    wider = np.empty((pool.shape[0], 2 * size + more * frames), dtype=pool.dtype)
    wider[:, :size] = pool[:, :size]
    return wider


@compiled
def predict(circles: Floats, coverage: Floats, k: int, direction: int, place: Floats) -> bool:
    """Carry a disc's centre on from the two nearest frames before one; false where it is lost.

    It is lost where the last one lies more than a few frames back.

    Parameters
    ----------
    circles, coverage
        Of one disc by frame, shape (frames, 3) and (frames,); negative in a frame without.
    direction
        1, or -1 to go back in time.
    place
        Filled with row and column.
    """
    last = k - direction
    while 0 <= last < coverage.size and coverage[last] < 0.0:
        last -= direction
    if not 0 <= last < coverage.size or abs(last - k) > MOST_MISSES + 1:
        return False
    before = last - direction
    while 0 <= before < coverage.size and coverage[before] < 0.0:
        before -= direction
    known = 0 <= before < coverage.size
    share = (k - last) / (last - before) if known else 0.0
    for a in range(2):
        place[a] = circles[last, a]
        if known:
            place[a] += share * (circles[last, a] - circles[before, a])
    return True


@part
def far_reach(circles: Floats, coverage: Floats, k: int, direction: int, radius: float) -> float:
    """Return how far a disc may be from where free flight takes it, pixels.

    That is `REACH` of its radius, unless a contact may change its motion by more than that from
    frame to frame (in a frame of the contact it hardly moves: the frame before that counts too), or
    its motion is not known yet.
    """
    nearest, later, step = -1, -1, -1.0
    j, steps = k - direction, 0
    while 0 <= j < coverage.size and steps < STEPS:
        if coverage[j] >= 0.0:
            nearest = j if nearest < 0 else nearest
            if later >= 0:
                moved = math.hypot(
                    circles[later, 0] - circles[j, 0], circles[later, 1] - circles[j, 1]
                )
                step = max(step, moved / abs(later - j))
                steps += 1
            later = j
        j -= direction
    if steps < STEPS:
        return max(FAR * radius, REVERSAL * step)
    reach = REVERSAL * step * abs(k - nearest)
    return reach if reach > REACH * radius else 0.0


@part
def expected(
    which: tuple[int, int, int], place: Floats, seen: tuple[Floats, Floats], guide: Floats
) -> bool:
    """Fill where a disc is looked for in a frame; false where it is not.

    Parameters
    ----------
    which
        Disc, frame, and the way: 0 in the frame to begin with, 1 after it, 2 before it.
    seen
        Circles and coverages so far.
    guide
        As in `follow_discs`.
    """
    disc, k, way = which
    if guide.shape[1] > 0:
        place[0], place[1] = guide[disc, k, 0], guide[disc, k, 1]
        return not math.isnan(place[0])
    return way == 0 or predict(seen[0][disc], seen[1][disc], k, 3 - 2 * way, place)


@part
def keep_apart(found: Look, discs: Floats, fresh: NDArray[np.bool_]) -> None:
    """Take back far places that are those of discs found before."""
    circles, coverage = found[0], found[2]
    for n in range(coverage.size):
        for m in range(coverage.size):
            if not fresh[n] or n == m or coverage[m] < 0.0 or (fresh[m] and m > n):
                continue
            apart = math.hypot(circles[n, 0] - circles[m, 0], circles[n, 1] - circles[m, 1])
            if apart < APART * (discs[n, 2] + discs[m, 2]):
                coverage[n] = -1.0


@part
def look_about(edges: Edges, discs: Floats, reach_px: float, rules: Rules) -> tuple[Look, bool]:
    """Fit the outlines of a frame that hold, and tell whether all do."""
    circles, covariance = discs.copy(), np.zeros((discs.shape[0], 3, 3))
    hidden = np.empty((discs.shape[0], 0, 2)), np.ones(discs.shape[0])
    accepted, ends, coverage = settle_outlines(
        edges, (circles, covariance), discs, hidden, rules[0]
    )
    every = True
    for n in range(discs.shape[0]):
        moved = math.hypot(circles[n, 0] - discs[n, 0], circles[n, 1] - discs[n, 1])
        grown = abs(circles[n, 2] - discs[n, 2])
        holds = moved < reach_px and grown < MOST_GROWTH * discs[n, 2]
        if coverage[n] < rules[1] or not holds:
            coverage[n], every = -1.0, False
    return (circles, covariance, coverage, accepted, ends), every


@part
def look_within(
    frame: Singles,
    filters: Filters,
    discs: Floats,
    search: tuple[float, NDArray[np.bool_]],
    rules: Rules,
) -> tuple[Floats, Integers, Look, bool]:
    """Find the edges of a frame within a distance of places, and the outlines that hold.

    Parameters
    ----------
    search
        The distance, pixels, and which discs go to the best peak of the votes first, shape
        (discs,).
    """
    near = discs.copy()
    near[:, 2] += search[0] + LIMB_REACH_PX + 1.0
    points, _, labels = edges_about(frame, near, filters[0], filters[1])
    edges = points[0], points[1], points[2], points[3]
    if search[1].any():
        peaks = peaks_near(edges, discs, search[0])
        for n in range(discs.shape[0]):
            if search[1][n] and peaks[n, 2] >= LEAST_RIM_SHARE:
                discs[n, :2] = peaks[n, :2]
    found, every = look_about(edges, discs, search[0], rules)
    return points, labels, found, every


@part
def look(
    frame: Singles, filters: Filters, discs: Floats, far: Floats, rules: Rules
) -> tuple[Floats, Integers, Look]:
    """Find the edges of a frame about some places, and the outlines that hold.

    First closely about the places; where that does not find every disc, further around them and
    from the best peaks of the votes; then those that move fast as far off as a contact may have
    sent them.

    Parameters
    ----------
    far
        That distance for each disc, pixels, shape (discs,); 0 for those that do not.
    """
    expected, reach = discs.copy(), REACH * float(discs[:, 2].mean())
    stay = np.zeros(discs.shape[0], dtype=np.bool_)
    points, labels, found, every = look_within(frame, filters, discs, (CLOSE_PX, stay), rules)
    if not every:
        points, labels, found, every = look_within(frame, filters, discs, (reach, ~stay), rules)
    missed = (found[2] < 0.0) & (far > reach)
    if missed.any():
        for n in range(missed.size):
            discs[n, :2] = expected[n, :2] if missed[n] else found[0][n, :2]
        search = float(far[missed].max()), missed
        points, labels, found, _ = look_within(frame, filters, discs, search, rules)
        keep_apart(found, discs, missed)
    return points, labels, found


@part
def keep(found: Look, own: Indices, k: int, outlines: Outlines, size: int) -> tuple[Floats, int]:
    """Put the outlines of a frame that hold to the film's; return accepted points and how many."""
    circles, covariance, coverage, accepted, spans = outlines
    first, accepted = 0, with_room(accepted, size, found[3].shape[0], coverage.shape[1])
    for n in range(own.size):
        d, last = own[n], found[4][n]
        if found[2][n] >= 0.0:
            circles[d, k], covariance[d, k] = found[0][n], found[1][n]
            coverage[d, k] = found[2][n]
            spans[d, k, 0], spans[d, k, 1] = size, size + last - first
            for m in range(first, last):
                accepted[0, size], accepted[1, size] = found[3][m, 0], found[3][m, 1]
                size += 1
        first = last
    return accepted, size


@compiled
def follow_discs(
    frames: Singles,
    filters: Filters,
    start: tuple[int, Floats, Floats],
    rules: Rules,
) -> tuple[FilmCurves, Outlines]:
    """Follow discs from the frame that shows them best, forth and back.

    Edges are looked for only where a disc may be: where its motion predicts it, with the reach.

    Parameters
    ----------
    frames
        Grey levels, shape (frames, rows, columns).
    start
        The frame to begin with; row, column and radius of each disc in it, pixels, shape (discs,
        3); and row and column of each disc in every frame, shape (discs, frames, 2), not a number
        where it is not looked for: where these are known, no motion is predicted. (discs, 0, 2)
        where they are not.
    rules
        Distance to keep off other discs, pixels, and that radii are free; share of its limb that an
        outline shows, to be believed.
    """
    film, discs = frames.shape[0], start[1].shape[0]
    circles, covariance = np.zeros((discs, film, 3)), np.zeros((discs, film, 3, 3))
    coverage, spans = np.full((discs, film), -1.0), np.zeros((discs, film, 2), dtype=np.intp)
    points, accepted = np.empty((5, 0)), np.empty((2, 0))
    labels, parts = np.empty((1, 0), dtype=np.int32), np.zeros((film, 2), dtype=np.intp)
    size, limb = 0, 0
    for way in range(3):
        # The first frame, those after it, and those before it.
        direction = (0, 1, -1)[way]
        k = start[0] + direction
        while 0 <= k < film:
            places, own, far = start[1].copy(), np.arange(discs), np.zeros(discs)
            count = 0
            for d in range(discs):
                place = places[count]
                place[2] = start[1][d, 2]
                if expected((d, k, way), place, (circles, coverage), start[2]):
                    own[count] = d
                    if way > 0 and start[2].shape[1] == 0:
                        far[count] = far_reach(circles[d], coverage[d], k, direction, place[2])
                    count += 1
            if count > 0:
                more, names, found = look(frames[k], filters, places[:count], far[:count], rules)
                points = with_room(points, size, names.size, film)
                labels = with_room(labels, size, names.size, film)
                points[:, size : size + names.size] = more
                labels[0, size : size + names.size] = names
                parts[k, 0], parts[k, 1] = size, size + names.size
                size += names.size
                outlines = circles, covariance, coverage, accepted, spans
                accepted, limb = keep(found, own[:count], k, outlines, limb)
            k = k + direction if way > 0 else film
    return (points, labels[0], parts), (circles, covariance, coverage, accepted, spans)
