"""Where a ball's first flight begins and its last one ends: hands hold and catch it.

A ball that is let go stays where it was held for as long as a search with a wide tolerance likes:
frames of a hand bend a flight more slowly than gravity does. A rest at the top of a flight is found
only where places were fitted.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.seen.arcs import LEAST_FRAMES, Arc, Chain

LEAST_KEPT = 2 * LEAST_FRAMES
MUCH_WIDER = 2.0
"""Scatter about one parabola over that of the sightings next to the bounce."""
SCATTER_RADII, SCATTER_PX = 0.02, 0.2
"""Scatter about a parabola that drag, and a ground that changes, may leave."""
PARABOLA, WITH_DRAG = 3, 5
"""Terms of a flight's rows: sightings show no drag, fitted places do."""
LEAST_RESTING = LEAST_FRAMES
AT_BOUNCE = 2
"""Places next to a bounce, which may lie on its other side."""
FITTED_RADII, FITTED_PX = 5e-4, 0.005
"""Scatter of fitted places that their light may leave."""


def flown(chain: Chain, radius_px: float) -> Chain:
    """Return a chain without the frames in which the ball is held before it, or caught after it."""
    least = SCATTER_RADII * radius_px + SCATTER_PX
    arcs = list(chain.arcs)
    first, last = arcs[0], arcs[-1]
    arcs[0] = first.part(_of_arc(first, least), len(first.frames))
    last = arcs[-1]
    turned = replace(last, times_s=-last.times_s[::-1], places=last.places[::-1])
    arcs[-1] = last.part(0, len(last.frames) - _of_arc(turned, least))
    return replace(chain, arcs=tuple(arcs))


def _of_arc(arc: Arc, least: float) -> int:
    return _begins(arc.times_s, arc.places[:, 0], least)


def rests(times_s: Floats, rows: Floats, radius_px: float) -> int:
    """Return how many places of a first flight come before the ball is let go.

    Of the last flight turned round, the same says how many come after the ball is caught. Fewer
    than LEAST_RESTING are none: a ball that enters the picture is placed badly before its light is
    learned.

    Parameters
    ----------
    times_s, rows
        Of fitted places up to the first bounce, s and px, shape (N,).
    """
    least = FITTED_RADII * radius_px + FITTED_PX
    found = _begins(times_s[:-AT_BOUNCE], rows[:-AT_BOUNCE], least, WITH_DRAG)
    return found if found >= LEAST_RESTING else 0


def _begins(times_s: Floats, rows: Floats, least: float, terms: int = PARABOLA) -> int:
    """Return the first place from which one curve goes through all the rest.

    Its bend is free: drag and a scale that is not known yet change it.
    """
    low, high = 0, len(rows) - LEAST_KEPT
    if high <= 0:
        return 0

    def scatter(first: int) -> float:
        return _scatter(times_s[first:], rows[first:], terms)

    allowed = max(least, MUCH_WIDER * scatter(min(high, len(rows) // 2)))
    if scatter(0) < allowed or scatter(high) >= allowed:
        return 0
    while high - low > 1:
        middle = (low + high) // 2
        if scatter(middle) < allowed:
            high = middle
        else:
            low = middle
    return high


def _scatter(times_s: Floats, rows: Floats, terms: int) -> float:
    """Return the scatter of rows about a polynomial of so many terms, px."""
    gone = times_s - times_s[0]
    design = np.vander(gone / max(float(np.abs(gone[-1])), 1e-9), terms)
    left = rows - design @ np.linalg.lstsq(design, rows, rcond=None)[0]
    return float(np.sqrt((left**2).sum() / max(1, len(gone) - terms)))
