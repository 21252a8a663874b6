"""Which recorded picture each field of a playback shows, with the probability of each answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.playback.changes import LONGEST_ADVANCE, Changes

Floats = NDArray[np.float64]

BINS = 20
"""Steps of the clock's phase in one picture."""
DRIFT = 0.004
"""Probability that the tape's clock shifts by a step between two fields, either way."""
REPEATED = 0.01
"""Probability that a grabber gives an old field again."""
MISJUDGED = 1e-4
"""Probability that a field is called new that shows the picture of the one before."""
LOST = 2e-3
"""Probability that a file without times leaves frames out, before each frame."""
MOST_AT_ONCE = 3
"""Frames that it leaves out at one place."""
WRONG_COUNT = 1e-4
"""Probability that the recorder's own count is wrong."""
RATE_TOLERANCE = 2e-3
"""By which the tape may run faster or slower than stated."""


@dataclass(frozen=True, slots=True)
class Clock:
    """How the tape ran while it was digitised.

    Attributes
    ----------
    pictures_per_s
        Pictures shown a second; 30 in normal playback (thesis, appendix A).
    first
        Number of the picture on the first field.
    counted
        Numbers that the recorder itself gave for some fields.
    fields_lost
        Fields of a frame, 1 or 2, where frames may be missing without a trace in the times, as in
        the file of a grabber that writes no times; 0 where the times tell.
    stands
        The tape stood on the first picture before it ran.
    """

    pictures_per_s: float
    first: int = 0
    counted: Mapping[int, int] | None = None
    fields_lost: Literal[0, 1, 2] = 0
    stands: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Numbers:
    """Recorded numbers of K fields, and how certain each is: two arrays of shape (K,)."""

    numbers: NDArray[np.int64]
    certainty: Floats


def numbered(seen: Changes, times_s: Floats, clock: Clock) -> Numbers:
    """Return the number of the picture on each field.

    A hidden Markov chain: its state is by how much the tape's clock is ahead of the stated rate,
    in steps of 1/20 picture; repeats, motion and the recorder's count are its observations, and
    forward and backward probabilities (Rabiner 1989) are added up for each number.

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
    offsets = _offsets(float(nominal[-1]), clock)
    steps = [_step(place, nominal, offsets, seen, clock) for place in range(len(nominal))]
    begins = ((offsets >= 0) & (offsets < 1)) * steps[0].likelihoods[0]
    posterior = _smoothed(begins, steps)
    numbers = np.empty(len(times_s), dtype=np.int64)
    certainty = np.empty(len(times_s))
    for place, start in enumerate(seen.starts):
        counts = _counts(nominal[start] + offsets)
        lowest = int(counts.min())
        shares = np.bincount(counts - lowest, posterior[start])
        numbers[place] = clock.first + lowest + int(shares.argmax())
        certainty[place] = shares.max() / shares.sum()
    return Numbers(numbers, certainty)


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """The way to a field from the one before.

    `likelihoods` are those of what is seen on the field in each state where 0, 1... frames are
    missing before it, shape (1 or MOST_AT_ONCE + 1, states); each moves the state by `jump`.
    """

    likelihoods: Floats
    jump: int

    def forward(self, states: Floats) -> Floats:
        """Return the probabilities after the field from those before it."""
        drifted = _drifted(states)
        ways = zip(self._chances(), self.likelihoods, strict=True)
        parts = [
            chance * _shifted(drifted, missing * self.jump) * likelihood
            for missing, (chance, likelihood) in enumerate(ways)
        ]
        return _normal(np.sum(parts, axis=0))

    def backward(self, states: Floats) -> Floats:
        """Return the likelihood of what follows the field before from that after this one."""
        ways = zip(self._chances(), self.likelihoods, strict=True)
        parts = [
            chance * _shifted(states * likelihood, -missing * self.jump)
            for missing, (chance, likelihood) in enumerate(ways)
        ]
        return _normal(_drifted(np.sum(parts, axis=0)))

    def _chances(self) -> list[float]:
        more = len(self.likelihoods) - 1
        return [1.0 - LOST] + more * [LOST / more] if more else [1.0]


def _offsets(pictures: float, clock: Clock) -> Floats:
    """Return the states: by how many pictures the tape may be ahead of its stated clock."""
    slack = 1.0 + RATE_TOLERANCE * pictures
    ahead = slack + (0.02 * pictures + 3 * MOST_AT_ONCE if clock.fields_lost else 0.0)
    return np.asarray((np.arange(-int(slack * BINS), int((1 + ahead) * BINS)) + 0.5) / BINS)


def _step(place: int, nominal: Floats, offsets: Floats, seen: Changes, clock: Clock) -> _Step:
    jump, most = 0, 0
    if place and clock.fields_lost and place % clock.fields_lost == 0:
        frame = float(np.median(np.diff(nominal))) * clock.fields_lost
        jump, most = round(frame * BINS), MOST_AT_ONCE
    now = _counts(nominal[place] + offsets)
    shown = _counts(nominal[seen.starts[place]] + offsets)
    likelihoods = np.ones((1 + most, len(offsets)))
    if clock.counted and place in clock.counted:
        likelihoods[:, shown + clock.first != clock.counted[place]] = WRONG_COUNT
    if place and seen.told:
        before = nominal[seen.starts[place - 1]]
        for missing in range(1 + most):
            ahead = now - _counts(before + offsets - missing * jump / BINS)
            likelihoods[missing] *= _seen(place, ahead, seen)
    return _Step(likelihoods, jump)


def _seen(place: int, ahead: NDArray[np.int64], seen: Changes) -> Floats:
    """Return the likelihood of a field's looks where its picture is so far ahead of the last."""
    if seen.starts[place] != place:
        return np.asarray(np.where(ahead > 0, REPEATED, 1.0))
    by_motion = seen.advance[place] - seen.advance[place].max()
    likelihood = np.exp(by_motion[np.clip(ahead, 0, LONGEST_ADVANCE)])
    return np.asarray(np.where(ahead > 0, likelihood, MISJUDGED * likelihood))


def _counts(pictures: Floats) -> NDArray[np.int64]:
    # Just above a whole number it is reached: sums of decimal numbers fall short of it.
    return np.floor(pictures + 1e-9).astype(np.int64)


def _smoothed(begins: Floats, steps: list[_Step]) -> Floats:
    """Return the probability of each state at each field, shape (K, states)."""
    posterior = np.empty((len(steps), len(begins)))
    posterior[0] = _normal(begins)
    for place in range(1, len(steps)):
        posterior[place] = steps[place].forward(posterior[place - 1])
    after = np.ones(len(begins))
    for place in range(len(steps) - 2, -1, -1):
        after = steps[place + 1].backward(after)
        posterior[place] *= after
    return np.asarray(posterior / posterior.sum(axis=1, keepdims=True))


def _normal(states: Floats) -> Floats:
    return np.asarray(states / states.sum())


def _drifted(states: Floats) -> Floats:
    """Return the states after the tape may have run a little faster or slower."""
    moved = (1 - DRIFT) * states
    moved[1:] += DRIFT / 2 * states[:-1]
    moved[:-1] += DRIFT / 2 * states[1:]
    return np.asarray(moved)


def _shifted(states: Floats, by: int) -> Floats:
    moved = np.zeros_like(states)
    if by >= 0:
        moved[by:] = states[: len(states) - by]
    else:
        moved[:by] = states[-by:]
    return moved
