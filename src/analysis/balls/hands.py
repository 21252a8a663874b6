"""Places at both ends of a film's flights where a hand is at the ball, or where it still rests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.flight.flights import Ints
from analysis.balls.seen.arcs import Chain
from analysis.balls.seen.free_fall import rests
from analysis.balls.seen.placing import Placed

MUCH_LEFT = 6.0
"""Mean square that a fit leaves, over the film's median: something else is at the ball."""


def free(placed: Placed, chain: Chain) -> Placed:
    """Return places without those at both ends of the film's flights where a hand is at the ball.

    What lies over the ball, or moves beside it, leaves much of the light unexplained. It is seen
    before the film has taught the ball's light: then so does a ball that is lit otherwise there.
    """
    if not len(placed.frames):
        return placed
    odd = placed.misfits > MUCH_LEFT * np.median(placed.misfits)
    first, last = chain.arcs[0], chain.arcs[-1]
    begins = odd & (placed.frames < first.frames[len(first.frames) // 2])
    ends = odd & (placed.frames > last.frames[len(last.frames) // 2])
    low = placed.frames[begins].max(initial=-1)
    high = placed.frames[ends].min(initial=int(last.frames[-1]) + 1)
    return placed.of((placed.frames > low) & (placed.frames < high))


def let_go(
    frames: Ints, rows: Floats, flown: tuple[Chain, Floats], radius_px: float
) -> NDArray[np.bool_]:
    """Return which places are none of a ball that rests before its flights or after them.

    Parameters
    ----------
    frames, rows
        Of the places, shape (N,).
    flown
        The flights, and the times of all frames, s.
    """
    chain, times_s = flown
    kept = np.ones(len(frames), dtype=bool)
    of_frame = dict(zip(frames.tolist(), rows.tolist(), strict=True))
    begins, ends = (frames[np.isin(frames, arc.frames)] for arc in (chain.arcs[0], chain.arcs[-1]))
    for own in (begins, ends[::-1]):
        heights = np.array([of_frame[frame] for frame in own.tolist()])
        kept &= ~np.isin(frames, own[: rests(times_s[own], heights, radius_px)])
    return kept
