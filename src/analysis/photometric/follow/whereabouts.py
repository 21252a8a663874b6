"""Where a sphere is in frames that hold no pose of it: it is still to be seen there in part.

A sphere comes into the frame before its centre does, and one that has left the front view may pass
through the mirror's for as long again. Taken for the scene behind the spheres, its picture moves
objects before it by tenths of a pixel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats

LEAD = 8
"""Frames at the end of a track from which it is extrapolated."""
DOUBT_PER_S = 0.04
"""m/s by which a sphere may go on otherwise: 0.06 px a frame at a thousand frames a second."""
MOST_DOUBT_M = 0.004
DOWN = np.array([1.0, 0.0, 0.0])


def whereabouts(
    centres: Floats, placed: NDArray[np.bool_], times_s: Floats, gravity: float
) -> tuple[Floats, Floats]:
    """Carry a track on in free flight beyond its ends, and straight through its gaps.

    Parameters
    ----------
    centres, placed
        m, rig axes, shape (F, 3), and which of them are known, shape (F,).
    times_s
        Shape (F,).
    gravity
        m/s^2 along +X.

    Returns
    -------
    Centres in all frames, m, shape (F, 3), and by how much they may be wrong, m, shape (F,). As
    they were given, and 0, where fewer than two are known.
    """
    known = np.flatnonzero(placed)
    doubt = np.zeros(len(times_s))
    if len(known) < 2:
        return centres, doubt
    whole = centres.copy()
    for axis in range(3):
        whole[:, axis] = np.interp(times_s, times_s[known], centres[known, axis])
    for end, own in ((known[0], known[:LEAD]), (known[-1], known[-LEAD:])):
        beyond = np.arange(len(times_s)) < end if end == known[0] else np.arange(len(times_s)) > end
        tau, ahead = times_s[own] - times_s[end], times_s[beyond] - times_s[end]
        straight = centres[own] - 0.5 * gravity * tau[:, None] ** 2 * DOWN
        spread = tau - tau.mean()
        velocity = spread @ straight / (spread @ spread)
        fallen = 0.5 * gravity * ahead[:, None] ** 2 * DOWN
        whole[beyond] = straight.mean(axis=0) + velocity * (ahead - tau.mean())[:, None] + fallen
        doubt[beyond] = np.minimum(DOUBT_PER_S * np.abs(ahead), MOST_DOUBT_M)
    return whole, doubt
