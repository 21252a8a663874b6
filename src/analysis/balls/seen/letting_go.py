"""Where a ball's first flight begins and its last one ends: hands hold and catch it.

A ball that is let go stays where it was held for as long as a search with a wide tolerance likes:
frames of a hand bend a flight more slowly than gravity does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.balls.seen.arcs import LEAST_FRAMES, Arc, Chain

LEAST_KEPT = 2 * LEAST_FRAMES
MUCH_WIDER = 2.0
"""Scatter about one parabola over that of the sightings next to the bounce."""
SCATTER_RADII, SCATTER_PX = 0.02, 0.2
"""Scatter about a parabola that drag, and a ground that changes, may leave."""


def flown(chain: Chain, radius_px: float) -> Chain:
    """Return a chain without the frames in which the ball is held before it, or caught after it."""
    least = SCATTER_RADII * radius_px + SCATTER_PX
    arcs = list(chain.arcs)
    first, last = arcs[0], arcs[-1]
    arcs[0] = first.part(_begins(first, least), len(first.frames))
    last = arcs[-1]
    turned = replace(last, times_s=-last.times_s[::-1], places=last.places[::-1])
    arcs[-1] = last.part(0, len(last.frames) - _begins(turned, least))
    return replace(chain, arcs=tuple(arcs))


def _begins(arc: Arc, least: float) -> int:
    """Return the first sighting from which one parabola goes through all the rest.

    Its bend is free: drag and a scale that is not known yet change it.
    """
    low, high = 0, len(arc.frames) - LEAST_KEPT
    if high <= 0:
        return 0
    allowed = max(least, MUCH_WIDER * _scatter(arc, min(high, len(arc.frames) // 2)))
    if _scatter(arc, 0) < allowed or _scatter(arc, high) >= allowed:
        return 0
    while high - low > 1:
        middle = (low + high) // 2
        if _scatter(arc, middle) < allowed:
            high = middle
        else:
            low = middle
    return high


def _scatter(arc: Arc, first: int) -> float:
    """Return the scatter of rows about a parabola from a sighting on, px."""
    gone = arc.times_s[first:] - arc.times_s[first]
    design = np.vander(gone / max(float(gone[-1]), 1e-9), 3)
    rows = arc.places[first:, 0]
    left = rows - design @ np.linalg.lstsq(design, rows, rcond=None)[0]
    return float(np.sqrt((left**2).sum() / max(1, len(gone) - 3)))
