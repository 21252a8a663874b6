"""Pieces of one flight that do not meet: the ball jumps along its way where frames are missing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from analysis.arrays import Floats
from analysis.balls.gaps import MOST_LOST, Gap, period_of
from analysis.balls.seen.arcs import TOLERANCE_PX, TOLERANCE_RADII, Arc, Sightings
from analysis.balls.seen.growing import LEAST_FRAMES, MEMORY, MOST_MISSES

REACH = 3
"""Sightings about the place where two pieces part that may belong to the other one."""
OFF_STEPS, NEAR_STEPS, LEAST_STEP_PX = 0.6, 0.25, 3.0
"""Of a step at the bounce, and the least such step: off both flights, and on one of them."""
BETTER = 2.5
"""Distances from the flight that a whole number of missing frames makes so many times smaller."""
MOST_BEND = 0.5
"""Relative: by drag, and a diameter that is wrong, a fall bends otherwise."""
ROUNDS, LEAST_AWAY_PX = 4, 0.1


def jumps(seen: Sightings, arcs: Sequence[Arc], radius_px: float, fall: Floats) -> list[Gap]:
    """Return where frames are missing, and how many.

    Neighbouring pieces are one flight, once they are put between; or what is seen next to a bounce
    lies on the flight before it or after it.

    Parameters
    ----------
    arcs
        In order of time.
    fall
        Free fall in the picture, (row, column) in px/s^2.
    """
    period = period_of(seen.times_s)
    found = []
    for a, b in pairwise(arcs):
        if min(len(a.frames), len(b.frames)) < LEAST_FRAMES:
            continue
        gap = _jump(a, b, radius_px, fall, period) or _at_bounce(seen, a, b, fall, period)
        if gap is not None:
            found.append(gap)
    return found


def _jump(a: Arc, b: Arc, radius_px: float, fall: Floats, period_s: float) -> Gap | None:
    if not 1 <= b.frames[0] - a.frames[-1] <= MOST_MISSES + 1:
        return None
    own_a, own_b = slice(-MEMORY, None), slice(0, MEMORY)
    frames = np.concatenate([a.frames[own_a], b.frames[own_b]])
    times = np.concatenate([a.times_s[own_a], b.times_s[own_b]])
    places = np.concatenate([a.places[own_a], b.places[own_b]])
    border = len(a.frames[own_a])
    tried = [
        (_distance(times + count * period_s * (frames >= first), places, fall), int(first), count)
        for count in range(MOST_LOST + 1)
        for first in frames[max(2, border - REACH) : border + REACH + 1]
    ]
    away, first, count = min(tried)
    unmoved = min(each[0] for each in tried if each[2] == 0)
    near = away < TOLERANCE_RADII * radius_px + TOLERANCE_PX
    return Gap(first, count) if count and near and BETTER * away < unmoved else None


def _at_bounce(seen: Sightings, a: Arc, b: Arc, fall: Floats, period_s: float) -> Gap | None:
    """Return frames that are missing where what is seen beside a bounce is steps off both flights.

    By the times that are stated the ball would be beyond the plate before it meets it, or high over
    it too early.
    """
    taken = {*a.frames.tolist(), *b.frames.tolist()}
    about = range(int(a.frames[-1]) - REACH, int(b.frames[0]) + REACH + 1)
    odd = [k for k in about if k not in taken and len(seen.places[k])]
    if not odd:
        return None
    # What an arc took beyond them it took by chance.
    a = a.part(0, int(np.searchsorted(a.frames, odd[0])))
    b = b.part(int(np.searchsorted(b.frames, odd[-1])), len(b.frames))
    loose = [k for k in range(a.frames[-1] + 1, b.frames[0]) if len(seen.places[k])]
    if min(len(a.frames), len(b.frames)) < LEAST_FRAMES or len(loose) > 2 * REACH:
        return None
    places = np.array([seen.places[k][0, :2] for k in loose])
    times, own = seen.times_s[loose], np.array(loose)
    step = period_s * float(np.hypot(*(_speed(a, fall, end=True))))

    def away(first: int, count: int) -> float:
        """Return how far the farthest lies from both flights with so many missing before one."""
        later = count * period_s * (own >= first)
        # The flight after the bounce is as much later as what follows the gap.
        along_a = np.hypot(*(places - _at(a, times + later, fall, end=True)).T)
        earlier = later - count * period_s
        along_b = np.hypot(*(places - _at(b, times + earlier, fall, end=False)).T)
        return float(np.minimum(along_a, along_b).max())

    tried = [
        (away(first, count), first, count)
        for count in range(1, MOST_LOST + 1)
        for first in range(loose[0], int(b.frames[0]) + 1)
    ]
    best, first, count = min(tried)
    clear = step > LEAST_STEP_PX and away(0, 0) > OFF_STEPS * step
    return Gap(first, count) if clear and best < NEAR_STEPS * step else None


def _speed(arc: Arc, fall: Floats, *, end: bool) -> Floats:
    middle, _, speed = arc.course(fall, end=end)
    return np.asarray(speed + fall * (arc.times_s[-1 if end else 0] - middle))


def _at(arc: Arc, times_s: Floats, fall: Floats, *, end: bool) -> Floats:
    """Return where a flight's end or start is at some times, shape (N, 2)."""
    middle, place, speed = arc.course(fall, end=end)
    gone = (times_s - middle)[:, None]
    return np.asarray(place + speed * gone + 0.5 * fall * gone**2)


def _distance(times: Floats, places: Floats, fall: Floats) -> float:
    """Return how far places lie from one fall, px, in the mean; without end where none bends so.

    By least distances: some sightings take the border of a shadow for the ball's.
    """
    gone = times - times.mean()
    design = np.stack([np.ones_like(gone), gone, 0.5 * gone**2], axis=1)
    weights = np.ones((len(gone), 1))
    away = np.zeros(len(gone))
    for _ in range(ROUNDS):
        row = np.linalg.lstsq(design * weights, places[:, :1] * weights, rcond=None)[0]
        column = np.linalg.lstsq(design[:, :2] * weights, places[:, 1:] * weights, rcond=None)[0]
        course = np.concatenate([design @ row, design[:, :2] @ column], axis=1)
        away = np.hypot(*(places - course).T)
        weights = np.sqrt(1.0 / np.maximum(away, LEAST_AWAY_PX))[:, None]
    bends = abs(float(row[2, 0]) / fall[0] - 1.0) < MOST_BEND
    return float(away.mean()) if bends else math.inf
