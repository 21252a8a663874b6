"""Whether bounces are those off a plate that leans, or off one that lies as it is said to."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.balls.flight.flights import SURE, Flights, Start

ANY_LEAN = 0.5
"""Standard error of the angle of a plate that may lie in any way, rad."""
FARTHEST = 4.5
"""Errors from which on a place counts no more than one that lies so far off its flight."""


def leaning_start(start: Start) -> Start | None:
    """Return bounces that are taken for those off a plate of any slope; None: they lie level."""
    if start.off_a_wall or len(start.times_s) < 2:
        return None
    slope = _slope(start)
    if abs(slope + _roll(start) - start.lean) < SURE * start.lean_sigma:
        return None
    return replace(start, lean=slope, lean_sigma=ANY_LEAN)


def _slope(start: Start) -> float:
    """Return the angle in the picture at which bounces lie beside one another, rad."""
    rows, columns = (start.places - start.places.mean(axis=0)).T
    square = float(columns @ columns)
    return math.atan(float(rows @ columns) / square) if square > 0.0 else 0.0


def _roll(start: Start) -> float:
    """Return the angle in the picture of the fall between bounces, rad."""
    down, across = (start.before[1:] - start.after[:-1]).sum(axis=0)
    return math.atan2(across, down)


def leans(leaning: Flights, level: Flights) -> bool:
    """Return whether a plate that leans surely explains more than one that lies as it is said to.

    Bounces of a ball that comes nearer sink in the picture of a camera that looks down, as if the
    plate did: what a fit asks one to believe counts as its places do.
    """
    if leaning.bounces != level.bounces:
        return leaning.bounces > level.bounces
    both = np.intersect1d(leaning.observed.frames, level.observed.frames)
    fits = [(each, np.isin(each.observed.frames, both)) for each in (leaning, level)]
    scatter = np.min([each.sigma_scale[own] for each, own in fits], axis=0)

    def unlikely(each: Flights, own: NDArray[np.bool_]) -> float:
        off = each.residuals[own] / (each.observed.sigmas[own] * scatter)
        return float((np.clip(off, -FARTHEST, FARTHEST) ** 2).sum()) + each.off_beliefs

    one, other = (unlikely(*each) for each in fits)
    return one + SURE**2 < other
