"""Which recorded picture each field of a playback shows, with the probability of each answer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.imaging.playback.chain import Chain, Clock
from analysis.imaging.playback.changes import Changes


@dataclass(frozen=True, slots=True, eq=False)
class Numbers:
    """Recorded numbers of K fields, and how certain each is: two arrays of shape (K,)."""

    numbers: NDArray[np.int64]
    certainty: Floats


def numbered(seen: Changes, times_s: Floats, clock: Clock) -> Numbers:
    """Return the number of the picture on each field.

    A hidden Markov chain. Its state is by how much the tape's clock is ahead of the stated rate,
    in steps of 1/20 picture, and how many fields old the picture was when it first showed: a
    grabber that repeats a field after a lost one shows what is new to us and old on the tape.
    Repeats, motion and the recorder's count are its observations, and forward and backward
    probabilities (Rabiner 1989) are added up for each number.

    Parameters
    ----------
    seen
        What the fields themselves say.
    times_s
        When each was taken, s, increasing, shape (K,).
    clock
        How the tape ran.
    """
    nominal = (times_s - times_s[0]) * clock.pictures_per_s
    chain = Chain(nominal, seen, clock)
    posterior = chain.smoothed()
    numbers = np.empty(len(times_s), dtype=np.int64)
    certainty = np.empty(len(times_s))
    for place, start in enumerate(seen.starts):
        counts = chain.shown(place)
        lowest = int(counts.min())
        shares = np.bincount((counts - lowest).ravel(), posterior[start].ravel())
        numbers[place] = clock.first + lowest + int(shares.argmax())
        certainty[place] = shares.max() / shares.sum()
    return Numbers(numbers, certainty)
