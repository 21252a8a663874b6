"""Whether what flies bends as a ball in free fall does."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.arrays import Floats
from analysis.balls.seen.arcs import Arc, Chain
from analysis.balls.seen.looks import Looks

FALL_SHARE = (0.5, 2.0)
"""Of the fall that follows from the ball's size: between these a ball flies."""
BEND_SHARE, BEND_SIGMAS = 0.12, 2.0
"""Flights of one ball bend alike: up to what drag and perspective change, and errors of places."""
LEAST_BEND = 1.5
"""In errors of a place: how far a flight lies off its chord, where it says anything."""
SEEN_RADII, SEEN_PX = 0.03, 0.3
"""Error of a place as seen first."""
STEADY_RADII = 0.5
"""A ball that stays within so many radii for all its frames is not in flight."""


def agreeing(chain: Chain, looks: Looks, fall: Floats) -> tuple[int, int]:
    """Return how many frames and flights of a chain bend alike, as those of one ball do.

    What is no ball goes through pieces of falls too, each of which bends in its own way.
    """
    bends = [(arc, _bend([arc], looks, fall)) for arc in chain.arcs]
    known = [(arc, *bend) for arc, bend in bends if bend is not None]
    most = 0, 0
    for _, middle, _ in known:
        alike = [
            arc
            for arc, bend, sigma in known
            if abs(bend - middle) < BEND_SHARE * middle + BEND_SIGMAS * sigma
        ]
        most = max(most, (len({int(frame) for arc in alike for frame in arc.frames}), len(alike)))
    return most


def falls(chain: Chain, looks: Looks, fall: Floats) -> bool:
    """Return whether a chain's flights bend as a fall does; one must be long enough to say.

    Anything that moves slowly goes through a few frames of some fall: a ball that rolls, or a hand.
    """
    bend = _bend(chain.arcs, looks, fall)
    if bend is None:
        return False
    (share, sigma), (low, high) = bend, FALL_SHARE
    return bool(low - 2 * sigma < share < high + 2 * sigma)


def _bend(arcs: Sequence[Arc], looks: Looks, fall: Floats) -> tuple[float, float] | None:
    """Return the bend of flights as a share of the fall, and its error; None: all too short."""
    error = SEEN_RADII * looks.radius_px + SEEN_PX
    weight = bend = 0.0
    for arc in arcs:
        lasts = float(arc.times_s[-1] - arc.times_s[0])
        if fall[0] * lasts**2 / 8 < LEAST_BEND * error:
            continue
        gone = arc.times_s - arc.times_s.mean()
        straight = np.stack([np.ones_like(gone), gone], axis=1)
        curve = 0.5 * gone**2
        curve = curve - straight @ np.linalg.lstsq(straight, curve, rcond=None)[0]
        weight += float(curve @ curve)
        bend += float(curve @ arc.places[:, 0])
    if weight == 0.0:
        return None
    return bend / weight / float(fall[0]), error / float(np.sqrt(weight) * fall[0])


def flying(chain: Chain, looks: Looks, fall: Floats) -> Chain:
    """Return a chain from its first flight up to the one that does not bend as a fall does.

    Places of a ball that is held, rests or rolls go through pieces of short falls, and those meet
    in bounces.
    """
    first, last = 0, len(chain.arcs)
    bends = [_bend([arc], looks, fall) for arc in chain.arcs]
    still = [each is not None and each[0] + each[1] < FALL_SHARE[0] for each in bends]
    while first < last - 1 and still[first] and _stays(chain.arcs[first], looks):
        first += 1
    last = next((k for k in range(first + 1, last) if still[k]), last)
    while last > first + 1 and bends[last - 1] is None:
        last -= 1
    bounces = slice(first, last - 1)
    return Chain(chain.arcs[first:last], chain.times_s[bounces], chain.places[bounces])


def _stays(arc: Arc, looks: Looks) -> bool:
    """Return whether a ball hardly moves in an arc, as one that is held."""
    return float(np.ptp(arc.places, axis=0).max()) < STEADY_RADII * looks.radius_px
