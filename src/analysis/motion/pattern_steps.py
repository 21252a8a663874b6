"""Steps of learning a marker pattern, compiled; `pattern` has them in words."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.cholesky import factor, solve
from analysis.compiled import compiled, part
from analysis.motion.alignment import turn_of
from analysis.motion.turning import turn_between, turned

Indices = NDArray[np.intp]

Seen = tuple[Floats, Floats, Indices]
"""Directions of all sightings frame by frame, shape (sightings, 3); their facing, (sightings,); and
the number up to the end of each frame, (frames,)."""

MATCH_ANGLE = 0.22
"""Radians between a marker and its predicted place; markers stand at least twice as far apart."""
NEW_MARKER_ANGLE = 0.30
OUTLIER_ANGLE = 0.10
LEAST_COMMON = 3
LEAST_SIGHTINGS = 3
ROUNDS, TRIES = 4, 3
MOST_MISSED = 2
BEGINNINGS, CLEARLY = 4, 1.05
"""Frames to begin at, evenly through a track, and by how much more shared markers win."""


@part
def span(ends: Indices, f: int) -> tuple[int, int]:
    """Return the first sighting of a frame and the one after its last."""
    return ends[f - 1] if f > 0 else 0, ends[f]


@part
def square_of(angle: float) -> float:
    """Return the square of the chord of an angle on the unit sphere."""
    return (2.0 * math.sin(angle / 2.0)) ** 2


@part
def match_frame(
    directions: Floats, pattern: Floats, rotation: Floats, limit: float, match: Indices
) -> int:
    """Fill the nearest marker to each sighting, -1 beyond a limit; return how many have one.

    Parameters
    ----------
    rotation
        Body to rig axes.
    limit
        Radians.
    """
    for n in range(directions.shape[0]):
        least, match[n] = square_of(limit), -1
        for m in range(pattern.shape[0]):
            square = 0.0
            for a in range(3):
                turned_back = 0.0
                for b in range(3):
                    turned_back += rotation[b, a] * directions[n, b]
                square += (turned_back - pattern[m, a]) ** 2
            if square < least:
                least, match[n] = square, m
    return distinct(match)


@part
def distinct(match: Indices) -> int:
    """Return how many different markers are matched: two views may show the same one."""
    count = 0
    for n in range(match.size):
        new = match[n] >= 0
        for k in range(n):
            if match[k] == match[n]:
                new = False
        count += new
    return count


@part
def fit_frame(directions: Floats, facing: Floats, pattern: Floats, match: Indices) -> Floats:
    """Return the rotation that takes the pattern to the sightings, weights facing squared."""
    s = np.zeros((3, 3))
    for n in range(match.size):
        if match[n] < 0:
            continue
        weight = facing[n] * facing[n]
        for a in range(3):
            for b in range(3):
                s[a, b] += weight * pattern[match[n], a] * directions[n, b]
    return turn_of(s)


@part
def add_strangers(
    directions: Floats, match: Indices, rotation: Floats, pattern: Floats, size: int
) -> int:
    """Add the sightings without a match to a pattern, each once; return its new size."""
    for n in range(directions.shape[0]):
        if match[n] >= 0:
            continue
        new = True
        for m in range(n):
            if match[m] < 0:
                square = 0.0
                for a in range(3):
                    square += (directions[n, a] - directions[m, a]) ** 2
                new = new and square >= square_of(NEW_MARKER_ANGLE)
        if new:
            for a in range(3):
                pattern[size, a] = 0.0
                for b in range(3):
                    pattern[size, a] += rotation[b, a] * directions[n, b]
            size += 1
    return size


@part
def follow_frame(
    seen: Seen, f: int, turn: Floats, match: Indices, known: tuple[Floats, int]
) -> tuple[int, Floats, int]:
    """Match a frame, add its new markers to a pattern; return common markers, rotation, new size.

    Parameters
    ----------
    turn
        Predicted orientation.
    known
        Markers in body axes, shape (sightings, 3), and how many there are.
    """
    (a, b), (pattern, size) = span(seen[2], f), known
    own, weights, found = seen[0][a:b], seen[1][a:b], match[a:b]
    common = match_frame(own, pattern[:size], turn, MATCH_ANGLE, found)
    for _ in range(TRIES):
        if common < LEAST_COMMON:
            return common, turn, size
        turn = fit_frame(own, weights, pattern, found)
        common = match_frame(own, pattern[:size], turn, MATCH_ANGLE, found)
    if common >= LEAST_COMMON:
        match_frame(own, pattern[:size], turn, NEW_MARKER_ANGLE, found)
        size = add_strangers(own, found, turn, pattern, size)
    return common, turn, size


@part
def first_pass(
    seen: Seen, times_s: Floats, begin: int, turns: tuple[Floats, Indices], pattern: Floats
) -> int:
    """Follow the pattern forward in time and back, adding markers as they come round the limb.

    A frame that none of the next MOST_MISSED follows was no good beginning: it is left out, and
    the pattern begins anew.

    Parameters
    ----------
    begin
        Frame to begin at.
    turns
        Filled for each frame: its orientation, and the number of markers in common with the
        pattern; fewer than LEAST_COMMON leave it out. Shapes (frames, 3, 3) and (frames,).
    pattern
        Filled with markers in body axes, shape (sightings, 3).

    Returns
    -------
    The number of markers.
    """
    (directions, facing, ends), (rotation, common) = seen, turns
    match, size, last = np.full(facing.size, -1, dtype=np.intp), 0, -1
    rate, first_rate, begun = np.zeros(3), np.zeros(3), -1
    common[:] = 0
    for f in range(begin, ends.size):
        if last >= 0 and last == begun and f > begun + MOST_MISSED:
            common[begun], last = 0, -1
        if last < 0:
            a, b = span(ends, f)
            match[a:b], rotation[f] = -1, np.eye(3)
            size = add_strangers(directions[a:b], match[a:b], rotation[f], pattern, 0)
            common[f] = size
            begun = last = f if size >= LEAST_COMMON else -1
            continue
        step = times_s[f] - times_s[last]
        turn = turned(rate * step, rotation[last])
        common[f], turn, size = follow_frame(seen, f, turn, match, (pattern, size))
        if common[f] >= LEAST_COMMON:
            rate = turn_between(rotation[last], turn) / step
            first_rate = rate if last == begun else first_rate
            rotation[f], last = turn, f
    if last < 0:
        return size
    last, rate = begun, first_rate
    for f in range(begun - 1, -1, -1):
        step = times_s[f] - times_s[last]
        turn = turned(rate * step, rotation[last])
        common[f], turn, size = follow_frame(seen, f, turn, match, (pattern, size))
        if common[f] >= LEAST_COMMON:
            rate = turn_between(rotation[last], turn) / step
            rotation[f], last = turn, f
    return size


@part
def best_pass(
    seen: Seen, times_s: Floats, rotation: Floats, common: Indices, space: Floats
) -> Floats:
    """Return the pattern of the first pass whose markers are shared by most frames.

    A track may begin with frames that mislead: another sphere before this one, or three markers
    that fit in two ways. The pass from its beginning is kept unless another is clearly better.

    Parameters
    ----------
    rotation, common
        Filled as by `first_pass`.
    space
        For patterns, shape (sightings, 3).
    """
    frames = seen[2].size
    size = first_pass(seen, times_s, 0, (rotation, common), space)
    best = space[:size].copy()
    # Each marker of a pattern was new in one frame.
    shared = common[common >= LEAST_COMMON].sum() - size
    for n in range(1, BEGINNINGS):
        turns, own = np.zeros((frames, 3, 3)), np.zeros(frames, dtype=np.intp)
        size = first_pass(seen, times_s, n * frames // BEGINNINGS, (turns, own), space)
        count = own[own >= LEAST_COMMON].sum() - size
        if count > max(CLEARLY * shared, 0.0):
            shared, best = count, space[:size].copy()
            rotation[:], common[:] = turns, own
    return best


@compiled
def average_pattern(
    seen: Seen, rotation: Floats, used: NDArray[np.bool_], match: Indices, size: int
) -> Floats:
    """Average each marker in body axes; forget those seen in too few frames, or on the limb alone.

    Parameters
    ----------
    rotation, used
        Orientation of each frame, shape (frames, 3, 3), and whether it has one, shape (frames,).
    match
        Marker of each sighting, -1 for none; renumbered, shape (sightings,).
    size
        Number of markers.

    Returns
    -------
    The pattern, shape (markers, 3).
    """
    directions, facing, ends = seen
    total, sighted = np.zeros((size, 3)), np.zeros(size, dtype=np.intp)
    latest = np.full(size, -1, dtype=np.intp)
    for f in range(ends.size):
        for n in range(*span(ends, f)):
            m = match[n]
            if not used[f] or m < 0:
                continue
            for a in range(3):
                for b in range(3):
                    total[m, a] += facing[n] * facing[n] * rotation[f, b, a] * directions[n, b]
            sighted[m] += latest[m] != f
            latest[m] = f
    least = min(LEAST_SIGHTINGS, used.sum())
    index, kept = np.full(size, -1, dtype=np.intp), 0
    for m in range(size):
        length = math.sqrt(total[m, 0] ** 2 + total[m, 1] ** 2 + total[m, 2] ** 2)
        # A marker that was never turned toward the camera has no weight, and so no place.
        if sighted[m] >= least and length > 0.0:
            total[kept] = total[m] / length
            index[m] = kept
            kept += 1
    for n in range(match.size):
        match[n] = index[match[n]] if match[n] >= 0 else -1
    return total[:kept].copy()


@compiled
def orientation_covariances(
    seen: Seen, rotation: Floats, used: NDArray[np.bool_], match: Indices, pattern: Floats
) -> Floats:
    """Return the covariance of each orientation, with the scatter of the sightings themselves.

    A sighting of weight w turns the sphere about every axis across its direction d: information
    w (1 - d d') / sigma^2. sigma comes from all residuals of the shot.

    Returns
    -------
    Shape (frames, 3, 3); 0 for a frame that is not used.
    """
    directions, facing, ends = seen
    covariance = np.zeros((ends.size, 3, 3))
    squares, freedom = 0.0, -2.0 * len(pattern) - 3.0 * used.sum()
    information = np.zeros((3, 3))
    for f in range(ends.size):
        if not used[f]:
            continue
        information[:] = 0.0
        for n in range(*span(ends, f)):
            if match[n] < 0:
                continue
            weight = facing[n] * facing[n]
            freedom += 2.0
            for a in range(3):
                expected = 0.0
                for b in range(3):
                    expected += rotation[f, a, b] * pattern[match[n], b]
                    information[a, b] -= weight * directions[n, a] * directions[n, b]
                information[a, a] += weight
                squares += weight * (directions[n, a] - expected) ** 2
        sound = factor(information, 3)
        for a in range(3):
            covariance[f, a, a] = 1.0 if sound else np.inf
            if sound:
                solve(information, 3, covariance[f, a])
    covariance *= squares / max(freedom, 1.0)
    return covariance


@compiled
def learn_pattern(seen: Seen, times_s: Floats) -> tuple[Floats, Floats, Floats, Indices, Indices]:
    """Learn the pattern of a sphere and its orientation in each frame.

    Parameters
    ----------
    times_s
        Of the frames, shape (frames,).

    Returns
    -------
    Pattern, shape (markers, 3); orientations and their covariances, shape (frames, 3, 3); marker of
    each sighting, -1 for none, shape (sightings,); and the number of markers that each frame has in
    common with the others, shape (frames,): fewer than LEAST_COMMON leave it out.
    """
    directions, facing, ends = seen
    rotation, common = np.zeros((ends.size, 3, 3)), np.zeros(ends.size, dtype=np.intp)
    space, match = np.empty((facing.size, 3)), np.full(facing.size, -1, dtype=np.intp)
    pattern = best_pass(seen, times_s, rotation, common, space)
    used = common >= LEAST_COMMON
    for _ in range(ROUNDS):
        for f in range(ends.size):
            a, b = span(ends, f)
            if used[f]:
                match_frame(directions[a:b], pattern, rotation[f], OUTLIER_ANGLE, match[a:b])
        pattern = average_pattern(seen, rotation, used, match, pattern.shape[0])
        for f in range(ends.size):
            a, b = span(ends, f)
            if not used[f]:
                match[a:b] = -1
                continue
            common[f] = distinct(match[a:b])
            used[f] = common[f] >= LEAST_COMMON
            if used[f]:
                rotation[f] = fit_frame(directions[a:b], facing[a:b], pattern, match[a:b])
    covariance = orientation_covariances(seen, rotation, used, match, pattern)
    return pattern, rotation, covariance, match, common
