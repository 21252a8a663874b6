"""Pieces of one flight that a search found apart, put together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.seen.arcs import FALL_SIGMA, Arc, one_arc, tolerance
from analysis.balls.seen.growing import MEMORY

LEAST_WHOLE = 4
"""Sightings on each side of the gap in which the ball is wholly in the picture."""
LEAST_AWAY = 3
"""Frames that a ball is out of the picture; a shorter gap is none to the search for arcs."""

LEAST_BEND, MOST_BEND = 0.5, 2.0
"""Of a fall's bend: what two pieces of one flight have together."""


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
    for arc in arcs:
        before = next(
            (k for k, a in enumerate(found) if _one(a, arc, radius_px, fall, shape)), None
        )
        if before is None:
            found.append(arc)
            continue
        found[before] = one_arc(found[before], arc)
    return sorted(found, key=lambda arc: float(arc.times_s[0]))


def _one(a: Arc, b: Arc, radius_px: float, fall: Floats, shape: tuple[int, int]) -> bool:
    """Return whether one fall goes through both, with nothing or the picture's border between."""
    missed = int(b.frames[0] - a.frames[-1])
    if missed < 1:
        return False
    # Of a ball that is partly outside something else than its centre is seen.
    whole_a, whole_b = (_inside(arc.places, radius_px, shape) for arc in (a, b))
    if min(whole_a.sum(), whole_b.sum()) < LEAST_WHOLE:
        return False
    times = np.concatenate([a.times_s[whole_a][-MEMORY:], b.times_s[whole_b][:MEMORY]])
    places = np.concatenate([a.places[whole_a][-MEMORY:], b.places[whole_b][:MEMORY]])
    middle = float(times.mean())
    gone = times - middle
    design = np.stack([np.ones_like(gone), gone, 0.5 * gone**2], axis=1)
    fitted = np.linalg.lstsq(design, places, rcond=None)[0]
    off = float(np.hypot(*(places - design @ fitted).T).max())
    bend, aside = (float(each) for each in fitted[2] / fall[0])
    # A ball that drifts keeps its speed across but for drag and perspective; walls turn it.
    if off > tolerance(radius_px) or abs(aside) > FALL_SIGMA:
        return False
    if missed <= LEAST_AWAY:
        # Sightings jump where the ground behind the ball changes; a bounce bends the other way.
        return LEAST_BEND < bend < MOST_BEND
    if abs(bend - 1.0) > FALL_SIGMA:
        return False
    away = 0.5 * (a.times_s[-1] + b.times_s[0]) - middle
    at = np.array([[1.0, away, 0.5 * away**2]]) @ fitted
    return not bool(_inside(at, radius_px, shape)[0])


def _inside(places: Floats, radius_px: float, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Return where a ball is wholly in the picture."""
    low, high = places.min(axis=1), (np.array(shape) - places).min(axis=1)
    return np.asarray((low > radius_px) & (high > radius_px))
