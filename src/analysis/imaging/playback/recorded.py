"""From the frames of a grabber to the pictures of the tape, each under its recorded number.

A field shows a recorded picture with a probability; one that no number is probable of is doubtful.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.imaging.playback.chain import Chain, Clock
from analysis.imaging.playback.changes import Changes, changes

CERTAIN = 0.99
"""Least probability of a number that is given to a field."""


@dataclass(frozen=True, slots=True)
class Doubtful:
    """Fields whose number is not certain: from `first` to `last`, likeliest `number`."""

    first: int
    last: int
    number: int
    certainty: float


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """Pictures of a tape as they were recorded.

    Attributes
    ----------
    pixels
        Mean of the fields that show each picture, shape (pictures, rows, columns).
    numbers
        Recorded number of each, increasing, shape (pictures,).
    fields
        How many fields show it, shape (pictures,); more than the rate gives are repeats.
    lost
        Numbers between the first and the last that no field shows with certainty.
    doubtful
        Fields that are left out because their number is not certain.
    told
        Whether repeats could be told from new pictures at all.
    """

    pixels: NDArray[np.uint8]
    numbers: NDArray[np.int64]
    fields: NDArray[np.int64]
    lost: tuple[int, ...]
    doubtful: tuple[Doubtful, ...]
    told: bool


def recorded_pictures(
    fields: Sequence[NDArray[np.uint8]], times_s: NDArray[np.float64], clock: Clock
) -> Recorded:
    """Put the fields of a digitised playback under the numbers of the tape's pictures.

    Parameters
    ----------
    fields
        What each shows, in the order of time, each of shape (rows, columns).
    times_s
        When each was taken, s, increasing.
    clock
        How the tape ran.

    Raises
    ------
    ValueError
        There are no fields, or their times do not increase.
    """
    if not len(fields) or len(fields) != len(times_s) or not (np.diff(times_s) > 0).all():
        raise ValueError("fields need increasing times, one each")
    stack = np.stack(fields)
    seen = changes(stack)
    begin = 0
    if clock.stands:
        # The tape ran from the last field of its first picture on, or a little before.
        begin = max(0, int(np.count_nonzero(seen.starts == 0)) - 1)
        stack, times_s = stack[begin:], times_s[begin:]
        seen = changes(stack)
    found = numbered(seen, times_s, clock)
    certain = found.certainty >= CERTAIN
    numbers = np.unique(found.numbers[certain])
    shown = [certain & (found.numbers == number) for number in numbers]
    pixels = [np.rint(stack[which].mean(axis=0)).astype(np.uint8) for which in shown]
    between = range(int(numbers[0]), int(numbers[-1])) if len(numbers) else range(0)
    return Recorded(
        pixels=np.stack(pixels) if pixels else np.empty((0, *stack.shape[1:]), np.uint8),
        numbers=numbers,
        fields=np.array([which.sum() for which in shown], dtype=np.int64),
        lost=tuple(sorted(set(between) - set(numbers.tolist()))),
        doubtful=_doubtful(begin, found.numbers, found.certainty),
        told=seen.told,
    )


def _doubtful(
    begin: int, numbers: NDArray[np.int64], certainty: NDArray[np.float64]
) -> tuple[Doubtful, ...]:
    """Join neighbouring fields of one uncertain number; the first of all fields is `begin`."""
    found: list[Doubtful] = []
    for place in np.flatnonzero(certainty < CERTAIN):
        field, number, share = begin + int(place), int(numbers[place]), float(certainty[place])
        if found and found[-1].last == field - 1 and found[-1].number == number:
            last = found.pop()
            found.append(Doubtful(last.first, field, number, min(last.certainty, share)))
        else:
            found.append(Doubtful(field, field, number, share))
    return tuple(found)


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
