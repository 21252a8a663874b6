"""An arc grown from two sightings: later and earlier ones through which the same fall goes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part

LEAST_SEED = 3
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
def _expected(
    times: NDArray[np.float64],
    places: NDArray[np.float64],
    fall: NDArray[np.float64],
    known: NDArray[np.intp],
    time: float,
) -> tuple[float, float]:
    """Return row and column at a time of the fall that fits some sightings best."""
    own_times, own = np.empty(len(known)), np.empty((len(known), 2))
    for n in range(len(known)):
        own_times[n] = times[known[n, 0]]
        for k in range(2):
            own[n, k] = places[known[n, 0], known[n, 1], k]
    middle, place, velocity = course(own_times, own, fall)
    later = time - middle
    for k in range(2):
        place[k] += velocity[k] * later + 0.5 * fall[k] * later * later
    return place[0], place[1]


_Seen = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_], NDArray[np.float64]]


@part
def _extend(seen: _Seen, taken: NDArray[np.intp], count: int, way: int) -> int:
    """Continue an arc into later frames (1) or earlier ones (-1); return how many it has."""
    times, places, free, rules = seen
    frames, most, _ = places.shape
    misses = 0
    frame = taken[count - 1, 0] + way
    while 0 <= frame < frames and misses < MOST_MISSES:
        known = taken[max(0, count - int(rules[REMEMBERED])) : count]
        row, column = _expected(times, places, rules[FALL:], known, times[frame])
        nearest, best = -1, rules[TOLERANCE]
        for index in range(most):
            away = math.hypot(places[frame, index, 0] - row, places[frame, index, 1] - column)
            if free[frame, index] and away < best:
                nearest, best = index, away
        if nearest >= 0:
            taken[count, 0], taken[count, 1] = frame, nearest
            count += 1
            misses = 0
        # A ball that has left the picture may come back on the same course.
        elif 0.0 <= row < rules[ROWS] and 0.0 <= column < rules[COLUMNS]:
            misses += 1
        frame += way
    return count


@compiled
def grow(
    times: NDArray[np.float64],
    places: NDArray[np.float64],
    free: NDArray[np.bool_],
    rules: NDArray[np.float64],
    taken: NDArray[np.intp],
) -> int:
    """Grow an arc from two sightings of neighbouring frames.

    Parameters
    ----------
    times
        Of the frames, s.
    places
        Row and column of each sighting of each frame, px; shape (frames, most, 2).
    free
        Which of these may be taken, shape (frames, most).
    rules
        How far from its course a sighting may lie, and the second seed from the first, px; rows and
        columns of the picture; from how many sightings it is continued; free fall (row, column),
        px/s^2. Shape (7,).
    taken
        Frame and index of both seeds, then of all sightings in order of time; (frames, 2).

    Returns
    -------
    How many sightings the arc has; 0 where the seeds lie too far apart or nothing follows them.
    """
    a, b = places[taken[0, 0], taken[0, 1]], places[taken[1, 0], taken[1, 1]]
    if math.hypot(b[0] - a[0], b[1] - a[1]) > rules[FURTHEST]:
        return 0
    count = _extend((times, places, free, rules), taken, 2, 1)
    if count < LEAST_SEED:
        return 0
    taken[:count] = taken[:count][::-1].copy()
    count = _extend((times, places, free, rules), taken, count, -1)
    taken[:count] = taken[:count][::-1].copy()
    return count
