"""The hidden Markov chain of a playback: the tape's clock behind what its fields show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.imaging.playback.changes import LONGEST_ADVANCE, Changes

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
OLDEST = 4
"""Fields by which a picture may be old that first shows after lost fields."""
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
class _Way:
    """One way from a field to the next: how old its picture is before and after, and how likely.

    `likelihood` is that of the way and of what is seen after it, shape (states,); `moved` is by
    how many states the clock moves, for frames that are missing.
    """

    before: int
    after: int
    moved: int
    likelihood: Floats


class Chain:
    """The hidden chain of K fields: states of shape (ages, offsets).

    Parameters
    ----------
    nominal
        Pictures that the tape has run at each field by its stated rate, shape (K,).
    seen, clock
        What the fields say, and how the tape ran.
    """

    def __init__(self, nominal: Floats, seen: Changes, clock: Clock) -> None:
        self._nominal, self._seen, self._clock = nominal, seen, clock
        self._offsets = _offsets(float(nominal[-1]), clock)
        steps = np.diff(nominal)
        self._field = float(np.median(steps)) if len(steps) else 1.0
        lost = np.rint(steps / self._field).astype(np.int64) - 1
        self._lost = np.concatenate([[0], np.maximum(lost, 0)])
        most = MOST_AT_ONCE * clock.fields_lost + int(self._lost.max())
        self._ages = 1 + min(OLDEST, most)

    def shown(self, place: int) -> NDArray[np.int64]:
        """Return the count of the picture on a field in each state, shape (ages, offsets)."""
        old = np.arange(self._ages)[:, None] * self._field
        return _counts(self._nominal[self._seen.starts[place]] + self._offsets - old)

    def smoothed(self) -> Floats:
        """Return the probability of each state at each field, shape (K, ages, offsets)."""
        fields = len(self._nominal)
        posterior = np.zeros((fields, self._ages, len(self._offsets)))
        begins = (self._offsets >= 0) & (self._offsets < 1)
        posterior[0, 0] = _normal(begins * self._recorded(0)[0])
        for place in range(1, fields):
            before = _drifted(posterior[place - 1])
            for way in self._ways(place):
                arrived = _shifted(before[way.before], way.moved) * way.likelihood
                posterior[place, way.after] += arrived
            posterior[place] = _normal(posterior[place])
        after = np.ones(posterior.shape[1:])
        for place in range(fields - 1, 0, -1):
            left = np.zeros_like(after)
            for way in self._ways(place):
                left[way.before] += _shifted(after[way.after] * way.likelihood, -way.moved)
            after = _normal(_drifted(left))
            posterior[place - 1] *= after
        return np.asarray(posterior / posterior.sum(axis=(1, 2), keepdims=True))

    def _ways(self, place: int) -> Iterator[_Way]:
        """Yield the ways to a field from the one before."""
        jump, chances = self._missing(place)
        recorded = self._recorded(place)
        new = self._seen.starts[place] == place
        for missing, chance in enumerate(chances):
            lost = int(self._lost[place]) + missing * self._clock.fields_lost
            oldest = min(self._ages - 1, lost)
            for before in range(self._ages):
                for after in range(oldest + 1) if new else (before,):
                    likelihood = chance * recorded[after]
                    if new:
                        likelihood = likelihood * REPEATED**after
                    if self._seen.told:
                        ahead = self._ahead(place, before, after if new else 0, missing * jump)
                        likelihood = likelihood * _seen(place, ahead, self._seen)
                    yield _Way(before, after, missing * jump, likelihood)

    def _missing(self, place: int) -> tuple[int, list[float]]:
        """Return the states of a missing frame, and how likely are 0, 1... without a trace."""
        fields = self._clock.fields_lost
        if not fields or place % fields:
            return 0, [1.0]
        some = MOST_AT_ONCE * [LOST / MOST_AT_ONCE]
        return round(self._field * fields * BINS), [1.0 - LOST, *some]

    def _ahead(self, place: int, before: int, after: int, moved: int) -> NDArray[np.int64]:
        """Return by how much a field's picture is ahead of the last in each state."""
        last = self._nominal[self._seen.starts[place - 1]] - before * self._field
        now = _counts(self._nominal[place] + self._offsets - after * self._field)
        return now - _counts(last + self._offsets - moved / BINS)

    def _recorded(self, place: int) -> Floats:
        """Return the likelihood of the recorder's count in each state, shape (ages, offsets)."""
        counted = (self._clock.counted or {}).get(place)
        if counted is None:
            return np.ones((self._ages, len(self._offsets)))
        right = self.shown(place) + self._clock.first == counted
        return np.where(right, 1.0, WRONG_COUNT)


def _offsets(pictures: float, clock: Clock) -> Floats:
    """Return the states: by how many pictures the tape may be ahead of its stated clock."""
    slack = 1.0 + RATE_TOLERANCE * pictures
    ahead = slack + (0.02 * pictures + 3 * MOST_AT_ONCE if clock.fields_lost else 0.0)
    return np.asarray((np.arange(-int(slack * BINS), int((1 + ahead) * BINS)) + 0.5) / BINS)


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


def _normal(states: Floats) -> Floats:
    return np.asarray(states / states.sum())


def _drifted(states: Floats) -> Floats:
    """Return the states after the tape may have run a little faster or slower."""
    moved = (1 - DRIFT) * states
    moved[..., 1:] += DRIFT / 2 * states[..., :-1]
    moved[..., :-1] += DRIFT / 2 * states[..., 1:]
    return np.asarray(moved)


def _shifted(states: Floats, by: int) -> Floats:
    moved = np.zeros_like(states)
    if by >= 0:
        moved[by:] = states[: len(states) - by]
    else:
        moved[:by] = states[-by:]
    return moved
