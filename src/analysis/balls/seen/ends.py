"""Sightings before a bounce that belong to a flight which bends less there than it did above.

A camera that looks down at a floor sees a ball fall ever less fast on its way there. Such a flight
leaves the course with the fall of its first sightings a few frames before its bounce, where it is
fastest and tells most of its speed.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.seen.arcs import SHOWN_AT_REST, Arc, Chain, Sightings, tolerance

LEAST_SIGHTINGS = 6
"""The last ones of a flight, whose parabola goes on, and earlier ones that bend more."""
LESS_BENT, LEAST_BENT = 0.85, 0.2
"""Of the most that earlier sightings bend, the bend of the last: less than places are in error by,
and more than that of a ball that rolls on."""


def lengthened(chain: Chain, seen: Sightings, radius_px: float, fall: Floats) -> Chain:
    """Return a chain whose flights go on to their bounces as far as the ball is seen on their way.

    Parameters
    ----------
    seen
        Every sighting of the ball, with the times of the chain.
    fall
        With which the chain was found, (row, column) in px/s^2.
    """
    arcs = list(chain.arcs)
    for k, time in enumerate(chain.times_s.tolist()):
        gap = range(int(arcs[k].frames[-1]) + 1, int(arcs[k + 1].frames[0]))
        before = [frame for frame in gap if seen.times_s[frame] < time]
        arcs[k] = _longer(arcs[k], before, seen, radius_px, fall)
    return replace(chain, arcs=tuple(arcs))


def _longer(arc: Arc, frames: list[int], seen: Sightings, radius_px: float, fall: Floats) -> Arc:
    """Return an arc with what is seen on its way in later frames, up to one in which nothing is."""
    step = float(np.median(np.diff(seen.times_s)))
    enough = math.sqrt(SHOWN_AT_REST * tolerance(radius_px) / max(1e-9, abs(float(fall[0]))))
    remembered = max(LEAST_SIGHTINGS, math.ceil(enough / max(step, 1e-9)))
    if len(arc.frames) <= remembered:
        return arc
    # A hand may still hold the ball in the first of them.
    pieces = [arc.part(k, k + remembered) for k in range(len(arc.frames) - remembered)]
    most = max(float(_parabola(piece, 0.0)[2] @ fall) for piece in pieces)
    for frame in frames:
        last = arc.part(len(arc.frames) - remembered, len(arc.frames))
        expected, _, bend = _parabola(last, float(seen.times_s[frame]))
        places = seen.places[frame]
        if not (LEAST_BENT * most < float(bend @ fall) < LESS_BENT * most and len(places)):
            break
        apart = np.hypot(*(places[:, :2] - expected).T)
        nearest = int(np.argmin(apart))
        if apart[nearest] > tolerance(radius_px):
            break
        arc = _with(arc, frame, seen, nearest)
    return arc


def _parabola(arc: Arc, time_s: float) -> Floats:
    """Return place, speed and acceleration at a time by all of an arc's sightings; shape (3, 2)."""
    gone = arc.times_s - time_s
    design = np.stack([np.ones_like(gone), gone, 0.5 * gone**2], axis=1)
    return np.asarray(np.linalg.lstsq(design, arc.places, rcond=None)[0])


def _with(arc: Arc, frame: int, seen: Sightings, index: int) -> Arc:
    row, column, response = seen.places[frame][index].tolist()
    return Arc(
        np.append(arc.frames, frame),
        np.append(arc.times_s, seen.times_s[frame]),
        np.vstack([arc.places, [row, column]]),
        arc.strength + response,
    )
