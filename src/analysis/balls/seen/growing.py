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


@part
def _course_of(
    times: NDArray[np.float64],
    places: NDArray[np.float64],
    fall: NDArray[np.float64],
    known: NDArray[np.intp],
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Return the course through some sightings, as `course` does."""
    own_times, own = np.empty(len(known)), np.empty((len(known), 2))
    for n in range(len(known)):
        own_times[n] = times[known[n, 0]]
        for k in range(2):
            own[n, k] = places[known[n, 0], known[n, 1], k]
    return course(own_times, own, fall)


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


Seen = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_], NDArray[np.float64]]


@part
def _extend(seen: Seen, taken: NDArray[np.intp], count: int, way: int) -> int:
    """Continue an arc into later frames (1) or earlier ones (-1); return how many it has."""
    times, places, free, rules = seen
    frames, most, _ = places.shape
    fall = rules[FALL:]
    misses = fitted = 0
    middle, place, velocity = 0.0, np.zeros(2), np.zeros(2)
    at = np.zeros(2)
    frame = taken[count - 1, 0] + way
    while 0 <= frame < frames and misses < MOST_MISSES:
        if fitted < count:
            known = taken[max(0, count - int(rules[REMEMBERED])) : count]
            middle, place, velocity = _course_of(times, places, fall, known)
            fitted = count
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
