"""An arc grown from two sightings: later and earlier ones through which the same fall goes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part

LEAST_SEED = 3
LEAST_FRAMES = 4
MOST_MISSES = 3
MEMORY = 14
"""An arc is continued from its last so many sightings at least: its course bends a little by drag,
and less than it does in a bounce."""
TOLERANCE, FURTHEST, ROWS, COLUMNS, REMEMBERED, FALL = range(6)


@compiled
def course(
    times: NDArray[np.float64], places: NDArray[np.float64], fall: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Return the middle of some times, and place and velocity then, by least squares.

    Parameters
    ----------
    times
        Shape (N,), s.
    places
        Row and column, px; shape (N, 2).
    fall
        Acceleration of free fall in the picture, (row, column), px/s^2.
    """
    count = len(times)
    middle = 0.0
    for n in range(count):
        middle += times[n] / count
    spread = 0.0
    place, velocity = np.zeros(2), np.zeros(2)
    for n in range(count):
        gone = times[n] - middle
        spread += gone * gone
        for k in range(2):
            straight = places[n, k] - 0.5 * fall[k] * gone * gone
            place[k] += straight / count
            velocity[k] += gone * straight
    for k in range(2):
        velocity[k] /= max(spread, 1e-300)
    return middle, place, velocity


Seen = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_], NDArray[np.float64]]
_COUNT, _TIMES, _SQUARES, _STRAIGHT, _TURNED, _SUMS = 0, 1, 2, 3, 5, 7
"""Sums over sightings: their number, times, squared times, and of row and column what is left of
them without the fall, plain and times the time."""


@part
def _sum(
    seen: Seen, sums: NDArray[np.float64], sighting: NDArray[np.intp], origin: float, sign: float
) -> None:
    """Add a sighting to sums, times counted from an origin; with the sign -1 take it out."""
    times, places, _, rules = seen
    gone = times[sighting[0]] - origin
    sums[_COUNT] += sign
    sums[_TIMES] += sign * gone
    sums[_SQUARES] += sign * gone * gone
    for k in range(2):
        straight = places[sighting[0], sighting[1], k] - 0.5 * rules[FALL + k] * gone * gone
        sums[_STRAIGHT + k] += sign * straight
        sums[_TURNED + k] += sign * gone * straight


@part
def _summed_course(
    sums: NDArray[np.float64], origin: float, fall: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Return the course through summed sightings, as `course` does."""
    middle = sums[_TIMES] / sums[_COUNT]
    spread = max(sums[_SQUARES] - middle * sums[_TIMES], 1e-300)
    place, velocity = np.empty(2), np.empty(2)
    for k in range(2):
        place[k] = sums[_STRAIGHT + k] / sums[_COUNT] + 0.5 * fall[k] * middle * middle
        turned = sums[_TURNED + k] - middle * sums[_STRAIGHT + k]
        velocity[k] = turned / spread + fall[k] * middle
    return middle + origin, place, velocity


@part
def _is_gone(
    at: NDArray[np.float64], onward: NDArray[np.float64], rules: NDArray[np.float64]
) -> bool:
    """Return whether a course has left the picture and does not come back.

    Parameters
    ----------
    at, onward
        Place and velocity along the course, in the way that it is followed.
    """
    for k in range(2):
        pull = rules[FALL + k]
        if at[k] > rules[ROWS + k] + rules[FURTHEST] and onward[k] >= 0.0 and pull >= 0.0:
            return True
        if at[k] < -rules[FURTHEST] and onward[k] <= 0.0 and pull <= 0.0:
            return True
    return False


@part
def _extend(seen: Seen, taken: NDArray[np.intp], count: int, way: int) -> int:
    """Continue an arc into later frames (1) or earlier ones (-1); return how many it has."""
    times, places, free, rules = seen
    frames, most, _ = places.shape
    fall, remembered = rules[FALL:], int(rules[REMEMBERED])
    misses = 0
    at, sums = np.zeros(2), np.zeros(_SUMS)
    frame = taken[count - 1, 0] + way
    origin = times[taken[count - 1, 0]]
    for n in range(max(0, count - remembered), count):
        _sum(seen, sums, taken[n], origin, 1.0)
    middle, place, velocity = _summed_course(sums, origin, fall)
    while 0 <= frame < frames and misses < MOST_MISSES:
        later = times[frame] - middle
        for k in range(2):
            at[k] = place[k] + (velocity[k] * later + 0.5 * fall[k] * later * later)
        nearest, best = -1, rules[TOLERANCE]
        for index in range(most):
            away = math.hypot(places[frame, index, 0] - at[0], places[frame, index, 1] - at[1])
            if free[frame, index] and away < best:
                nearest, best = index, away
        if nearest >= 0:
            taken[count, 0], taken[count, 1] = frame, nearest
            _sum(seen, sums, taken[count], origin, 1.0)
            if count >= remembered:
                _sum(seen, sums, taken[count - remembered], origin, -1.0)
            middle, place, velocity = _summed_course(sums, origin, fall)
            count += 1
            misses = 0
        # A ball that has left the picture may come back on the same course.
        elif 0.0 <= at[0] < rules[ROWS] and 0.0 <= at[1] < rules[COLUMNS]:
            misses += 1
        elif _is_gone(at, way * (velocity + later * fall), rules):
            break
        frame += way
    return count


@compiled
def next_arc(seen: Seen, seed: NDArray[np.intp], taken: NDArray[np.intp]) -> int:
    """Grow the next arc from two sightings of neighbouring frames, in order of time.

    Each seed is tried once, from where the arc before was found: which sightings are free changes
    by those alone that are taken.

    Parameters
    ----------
    seen
        Times of the frames, s; row and column of each sighting of each frame, px, shape
        (frames, most, 2); which of these may be taken, shape (frames, most); and rules: how far
        from its course a sighting may lie, and the second seed from the first, px; rows and columns
        of the picture; from how many sightings it is continued; free fall (row, column), px/s^2.
    seed
        Frame of the first sighting, index of both: where to begin; moved on. Shape (3,).
    taken
        Filled: frame and index of all sightings in order of time; (frames, 2).

    Returns
    -------
    How many sightings the arc has; 0 where there is no more.
    """
    _, places, free, _ = seen
    frames, most, _ = places.shape
    while most > 0 and seed[0] < frames - 1:
        taken[0, 0], taken[0, 1] = seed[0], seed[1]
        taken[1, 0], taken[1, 1] = seed[0] + 1, seed[2]
        seed[2] += 1
        if seed[2] == most:
            seed[1], seed[2] = seed[1] + 1, 0
        if seed[1] == most:
            seed[0], seed[1] = seed[0] + 1, 0
        if free[taken[0, 0], taken[0, 1]] and free[taken[1, 0], taken[1, 1]]:
            count = _grow(seen, taken)
            if count >= LEAST_FRAMES:
                return count
    return 0


@part
def _grow(seen: Seen, taken: NDArray[np.intp]) -> int:
    """Grow an arc from two sightings; 0 where they lie too far apart or nothing follows them."""
    _, places, _, rules = seen
    a, b = places[taken[0, 0], taken[0, 1]], places[taken[1, 0], taken[1, 1]]
    if math.hypot(b[0] - a[0], b[1] - a[1]) > rules[FURTHEST]:
        return 0
    count = _extend(seen, taken, 2, 1)
    if count < LEAST_SEED:
        return 0
    taken[:count] = taken[:count][::-1].copy()
    count = _extend(seen, taken, count, -1)
    taken[:count] = taken[:count][::-1].copy()
    return count
