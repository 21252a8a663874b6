"""Orientations that contradict each other: a free sphere turns at one rate between contacts.

Where few markers are seen an orientation may be wrong by a marker's distance and more, frame after
frame, at a stated error of a degree. A least-squares line through all of them would be wrong by
many of its errors: orientations are kept as far as one rate holds them together.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.motion.rotation import rotation_matrix, rotation_vector

GATE_SIGMAS, GATE_RAD = 4.0, 0.02
"""What an orientation may lie off a rate: so many of its errors and this angle besides."""
FINEST_RAD = 0.01
"""Error below which an orientation has no more weight."""
TRIED = 24
"""Frames through which rates are tried, evenly through the track."""
SHORTEST = 0.125
"""Of a pair of frames that gives a rate, share of the track."""
MOST_ASTRAY, LEAST_TOGETHER = 0.05, 0.5
"""Share of the weight off the best rate that a robust fit bears, and that the best rate needs."""


def agreeing_turns(times_s: Floats, rotations: Floats, sigma: Floats) -> NDArray[np.bool_]:
    """Return which orientations of one side of a contact agree with one rate, shape (frames,).

    All of them where hardly any lies off it; none where less than half of their weight agrees.

    Parameters
    ----------
    times_s, sigma
        Times, s, and standard errors about each axis, slow ones included, rad, shape (frames,).
    rotations
        Body to rig axes, shape (frames, 3, 3).
    """
    count = len(times_s)
    if count < 4:
        return np.ones(count, dtype=np.bool_)
    gate = GATE_SIGMAS * sigma + GATE_RAD
    weight = 1.0 / (sigma**2 + FINEST_RAD**2)
    steps = rotation_vector(rotations[1:] @ rotations[:-1].swapaxes(1, 2))
    rate = np.median(steps / np.diff(times_s)[:, None], axis=0)
    tried = np.unique(np.linspace(0, count - 1, TRIED).astype(np.intp))
    best, share = np.ones(count, dtype=np.bool_), 0.0
    for anchor in tried:
        since = times_s - times_s[anchor]
        expected = rotation_matrix(rate * since[:, None]) @ rotations[anchor]
        off = rotation_vector(rotations @ expected.swapaxes(1, 2))
        ends = tried[np.abs(since[tried]) > SHORTEST * np.ptp(times_s)]
        # The rate through the anchor and each of the ends, to first order in what it changes.
        changes = off[ends] / since[ends, None]
        left = off[None] - changes[:, None] * since[None, :, None]
        agree = (left**2).sum(axis=2) <= gate**2
        own = (agree * weight).sum(axis=1) / weight.sum()
        if own.max(initial=0.0) > share:
            share, best = float(own.max()), agree[own.argmax()]
    if share >= 1.0 - MOST_ASTRAY:
        return np.ones(count, dtype=np.bool_)
    return best if share >= LEAST_TOGETHER else np.zeros(count, dtype=np.bool_)
