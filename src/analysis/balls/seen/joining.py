"""Pieces of one flight that a search found apart, put together."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.seen.arcs import FALL_SIGMA, Arc, one_arc, tolerance
from analysis.balls.seen.growing import MEMORY
from analysis.compiled import compiled, part

LEAST_WHOLE = 4
"""Sightings on each side of the gap in which the ball is wholly in the picture."""
LEAST_AWAY = 3
"""Frames that a ball is out of the picture; a shorter gap is none to the search for arcs."""

LEAST_BEND, MOST_BEND = 0.5, 2.0
"""Of a fall's bend: what two pieces of one flight have together."""
LEAST_BENT, TINY = 1e-9, 1e-300
"""Of the squared times from their middle: what is left of them where they tell a bend."""


Ends = NDArray[np.float64]
"""Time, row and column of the last sightings of pieces; shape (N, MEMORY, 3)."""
_KNOWN, _FRAME, _TIME = range(3)
_TOLERANCE, _RADIUS, _ROWS, _COLUMNS, _FALL = range(5)


def joined(
    arcs: Sequence[Arc], radius_px: float, fall: Floats, shape: tuple[int, int]
) -> list[Arc]:
    """Return arcs in order of time, those put together through which one free fall goes.

    Parameters
    ----------
    fall
        Free fall in the picture, (row, column) in px/s^2.
    shape
        Rows and columns of the picture.
    """
    found: list[Arc] = []
    ends, lasts = np.zeros((len(arcs), MEMORY, 3)), np.zeros((len(arcs), 3))
    rules = np.array([tolerance(radius_px), radius_px, *map(float, shape), float(fall[0])])
    for arc in arcs:
        # Of a ball that is partly outside something else than its centre is seen.
        whole = _inside(arc.places, radius_px, shape)
        seen = np.column_stack([arc.times_s, arc.places])[whole]
        begins = np.array([float(len(seen)), float(arc.frames[0]), float(arc.times_s[0])])
        k = continued(ends, lasts, len(found), (seen[:MEMORY].copy(), begins), rules)
        if k == len(found):
            found.append(arc)
        else:
            found[k] = one_arc(found[k], arc)
            seen = np.concatenate([ends[k, : int(lasts[k, _KNOWN])], seen])
        tail = seen[-MEMORY:]
        ends[k, : len(tail)] = tail
        lasts[k] = len(tail), arc.frames[-1], arc.times_s[-1]
    return sorted(found, key=lambda arc: float(arc.times_s[0]))


def _inside(places: Floats, radius_px: float, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Return where a ball is wholly in the picture."""
    low, high = places.min(axis=1), (np.array(shape) - places).min(axis=1)
    return np.asarray((low > radius_px) & (high > radius_px))


@compiled
def continued(
    ends: Ends, lasts: Floats, count: int, start: tuple[Floats, Floats], rules: Floats
) -> int:
    """Return the first of some pieces that another one continues; their number where none is.

    Parameters
    ----------
    ends, lasts
        Of the pieces: last sightings; how many these are, and the last frame and its time. Shapes
        (N, MEMORY, 3) and (N, 3).
    start
        Of the other one: first sightings, shape (M, 3); how many it has, first frame and its time.
    rules
        How far from a fall a sighting may lie, the ball's radius, rows and columns of the picture,
        px, and the fall, px/s^2.
    """
    seen, begins = start
    both = np.empty((2 * MEMORY, 3))
    for k in range(count):
        known = int(lasts[k, _KNOWN])
        missed = begins[_FRAME] - lasts[k, _FRAME]
        if missed < 1 or min(known, len(seen)) < LEAST_WHOLE:
            continue
        both[:known] = ends[k, :known]
        both[known : known + len(seen)] = seen
        away = 0.5 * (lasts[k, _TIME] + begins[_TIME])
        if _is_one(both[: known + len(seen)], missed, away, rules):
            return k
    return count


@part
def _is_one(seen: Floats, missed: float, away_s: float, rules: Floats) -> bool:
    """Return whether one fall goes through sightings of two pieces.

    Of a gap that a search would follow over, nothing else is asked; in the middle of a longer one
    the ball must be outside the picture.

    Parameters
    ----------
    seen
        Time, row and column, shape (N, 3).
    missed, away_s
        Frames from one piece to the other, and the time in the middle of them.
    """
    middle, skew, mean, course = _parabola(seen)
    if mean < 0.0:
        return False
    for n in range(len(seen)):
        at = _at(seen[n, 0] - middle, skew, mean, course)
        off = math.hypot(seen[n, 1] - at[0], seen[n, 2] - at[1])
        if off > rules[_TOLERANCE]:
            return False
    bend, aside = 2.0 * course[0, 2] / rules[_FALL], 2.0 * course[1, 2] / rules[_FALL]
    # A ball that drifts keeps its speed across but for drag and perspective; walls turn it.
    if abs(aside) > FALL_SIGMA:
        return False
    if missed <= LEAST_AWAY:
        # Sightings jump where the ground behind the ball changes; a bounce bends the other way.
        return bool(LEAST_BEND < bend < MOST_BEND)
    if abs(bend - 1.0) > FALL_SIGMA:
        return False
    at = _at(away_s - middle, skew, mean, course)
    low = min(at[0], at[1])
    high = min(rules[_ROWS] - at[0], rules[_COLUMNS] - at[1])
    return bool(min(low, high) <= rules[_RADIUS])


@part
def _parabola(seen: Floats) -> tuple[float, float, float, Floats]:
    """Return the parabola through sightings by least squares: it is linear in its terms.

    With the time t from the middle of all, the terms 1, t and t^2 - s t - m are orthogonal over the
    sightings: each coefficient is a sum of its own.

    Returns
    -------
    The middle, s and m, less than 0 where the times tell no bend, and the coefficients of the row's
    and the column's terms, shape (2, 3).
    """
    count = len(seen)
    middle = seen[:, 0].mean()
    squares = cubes = 0.0
    for n in range(count):
        gone = seen[n, 0] - middle
        squares += gone * gone
        cubes += gone * gone * gone
    skew, mean = cubes / max(squares, TINY), squares / count
    bent = 0.0
    course = np.zeros((2, 3))
    for n in range(count):
        gone = seen[n, 0] - middle
        curve = gone * gone - skew * gone - mean
        bent += curve * curve
        for k in range(2):
            course[k, 0] += seen[n, 1 + k] / count
            course[k, 1] += gone * seen[n, 1 + k]
            course[k, 2] += curve * seen[n, 1 + k]
    if bent <= LEAST_BENT * squares * mean:
        return middle, 0.0, -1.0, course
    course[:, 1] /= max(squares, TINY)
    course[:, 2] /= max(bent, TINY)
    return middle, skew, mean, course


@part
def _at(gone: float, skew: float, mean: float, course: Floats) -> tuple[float, float]:
    """Return row and column of a parabola at a time from its middle."""
    curve = gone * gone - skew * gone - mean
    row = course[0, 0] + course[0, 1] * gone + course[0, 2] * curve
    return row, course[1, 0] + course[1, 1] * gone + course[1, 2] * curve
