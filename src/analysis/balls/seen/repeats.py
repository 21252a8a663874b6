"""Pictures that a film shows once more: single ones, or in the rhythm of another rate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError

HARDLY, LEAST_STEP_PX = 0.15, 2.0
"""Share of the steps beside it that the disc of a picture shown twice moves at most, and the least
of these steps, px."""
SLOW, FAST_QUANTILE = 0.15, 0.9
"""Of the ball's fast steps: it moves by less in the frames beside one in which it rests or is at
the top of a flight."""
CLEARLY, BESIDE = 0.4, 4
"""Share of the largest step within so many frames that the disc of a new picture moves at least."""
MOST_FRAMES, LEAST_REPEATS = 30, 4
"""Frames of the longest rhythm of repeats, and how many repeats are to be seen of one."""
REPEATS_KEPT, NEW_KEPT = 0.9, 0.95
"""Of the repeats of a rhythm and of its new pictures, those that are seen to be so."""
MOST_UNEVEN = 0.3
"""Of the time from frame to frame."""


@dataclass(frozen=True, slots=True)
class Rhythm:
    """Each so many frames of a film show so many pictures.

    Attributes
    ----------
    pictures, frames
        Without a common divisor.
    phase
        Frames of it before the film's first.
    """

    pictures: int
    frames: int
    phase: int

    def repeats(self, count: int) -> NDArray[np.bool_]:
        """Return which of a film's frames show the picture before them, shape (count,)."""
        shown = (np.arange(-1, count) + self.phase) * self.pictures // self.frames
        again = np.diff(shown) == 0
        again[:1] = False
        return np.asarray(again)


class BroughtToRateError(ShotRefusedError):
    """A film that repeats its pictures in a rhythm: it was brought to another rate.

    Parameters
    ----------
    rhythm
        Of its repeats.
    """

    def __init__(self, rhythm: Rhythm) -> None:
        super().__init__(
            "frames",
            f"each {rhythm.frames} frames show {rhythm.pictures} pictures: the film was brought to "
            "another rate; state the film that the camera wrote",
        )
        self.rhythm = rhythm


def evenly_timed(times_s: Floats) -> bool:
    """Return whether frames have the times of a rate, but for how a file rounds them."""
    gone = np.diff(times_s)
    return bool(np.ptp(gone) <= MOST_UNEVEN * np.median(gone))


def refuse_brought_to_rate(places: Sequence[Floats], times_s: Floats) -> None:
    """Raise `BroughtToRateError` where even frames repeat pictures that are evenly spaced in time.

    A picture in the place of one that was lost is followed by a step of two: times of the others
    are right then.

    Parameters
    ----------
    places
        Of each frame row, column and response of what looks like the ball, the surest first.
    times_s
        Of the frames, s.
    """
    if len(times_s) <= MOST_FRAMES or not evenly_timed(times_s):
        return
    steps = _steps(places)
    told = _told(steps)
    rhythm = _rhythm(told, len(places))
    if rhythm is not None and _is_even(rhythm, steps, told):
        raise BroughtToRateError(rhythm)


def repeated(places: Sequence[Floats]) -> tuple[int, ...]:
    """Return frames that show the picture before them once more.

    All that is seen in such a frame is where it was, to the bit. Where a codec has coded the second
    picture anew, the surest disc has moved by a small share of its steps before and after, which
    point the same way: at the top of a flight and on the plate they do not. A codec skips a ball
    that is held, or at the top of a flight, too: what says that pictures are shown twice is a ball
    that moves before and after.
    """
    steps = _steps(places)
    sizes = np.hypot(*steps.T)
    beside = np.minimum(sizes[:-2], sizes[2:])
    onward = (steps[:-2] * steps[2:]).sum(axis=1) > 0
    hardly = (sizes[1:-1] < HARDLY * beside) & (beside > LEAST_STEP_PX) & onward
    nearly = {2 + int(k) for k in np.flatnonzero(hardly)}
    again = [
        k
        for k in range(1, len(places))
        if len(places[k]) and np.array_equal(places[k], places[k - 1])
    ]
    if not nearly and not _moves_beside(again, sizes):
        return ()
    return tuple(sorted({*again, *nearly}))


def _steps(places: Sequence[Floats]) -> Floats:
    """Return by how much the surest disc moves from each frame to the next, px, shape (N - 1, 2).

    Nan where it is not seen.
    """
    middle = np.array([p[0, :2] if len(p) else (np.nan, np.nan) for p in places]).reshape(-1, 2)
    return np.diff(middle, axis=0)


def _moves_beside(again: Sequence[int], sizes: Floats) -> bool:
    """Return whether a ball moves before and after some pictures that repeat the one before.

    Parameters
    ----------
    again
        Frames of these pictures.
    sizes
        Of its steps from each frame to the next, px; nan where it is not seen.
    """
    least = SLOW * np.nanquantile(sizes, FAST_QUANTILE) if np.isfinite(sizes).any() else np.inf
    for k in again:
        first = last = k
        while first - 1 in again:
            first -= 1
        while last + 1 in again:
            last += 1
        # Step n goes from frame n to frame n + 1.
        if first >= 2 and last < len(sizes) and min(sizes[first - 2], sizes[last]) > least:
            return True
    return False


def _told(steps: Floats) -> NDArray[np.intp]:
    """Return which steps lead to a new picture (0) and which to the one before (1); -1: not told.

    A ball that hardly moves, or turns round at the top of a flight or on the plate, tells nothing.
    """
    sizes = np.nan_to_num(np.hypot(*steps.T))
    found = np.full(len(sizes), -1, dtype=np.intp)
    for n, size in enumerate(sizes.tolist()):
        low = max(0, n - BESIDE)
        before, after = sizes[low:n], sizes[n + 1 : n + 1 + BESIDE]
        if not (len(before) and len(after)) or not np.isfinite(steps[n]).all():
            continue
        a, b = low + int(np.argmax(before)), n + 1 + int(np.argmax(after))
        least = min(sizes[a], sizes[b])
        if least < LEAST_STEP_PX or float(steps[a] @ steps[b]) <= 0.0:
            continue
        if size < HARDLY * least:
            found[n] = 1
        elif size > CLEARLY * least:
            found[n] = 0
    return found


def _rhythm(told: NDArray[np.intp], frames: int) -> Rhythm | None:
    """Return the shortest rhythm that repeats keep; None where they keep none."""
    again, new = told == 1, told == 0
    if again.sum() < LEAST_REPEATS:
        return None
    for length in range(2, MOST_FRAMES + 1):
        for pictures in range(1, length):
            if math.gcd(pictures, length) > 1:
                continue
            for phase in range(length):
                rhythm = Rhythm(pictures, length, phase)
                expected = rhythm.repeats(frames)[1:]
                kept = int((again & expected).sum())
                if (
                    kept >= max(LEAST_REPEATS, REPEATS_KEPT * ((again | new) & expected).sum())
                    and (new & ~expected).sum() >= NEW_KEPT * ((again | new) & ~expected).sum()
                ):
                    return rhythm
    return None


def _is_even(rhythm: Rhythm, steps: Floats, told: NDArray[np.intp]) -> bool:
    """Return whether pictures are evenly spaced in time, however many frames show each.

    Where a picture that is shown longer is followed by a step that is as much longer, they are not.
    """
    if rhythm.pictures == 1:
        return True
    first = np.flatnonzero(~rhythm.repeats(len(steps) + 1))
    shown = np.diff(first).astype(np.float64)
    sizes = np.array(
        [
            np.hypot(*steps[a:b].sum(axis=0)) if (told[a:b] >= 0).all() else np.nan
            for a, b in zip(first[:-1].tolist(), first[1:].tolist(), strict=True)
        ]
    )
    longer = shown[1:] != shown[:-1]
    known = longer & np.isfinite(sizes[1:]) & np.isfinite(sizes[:-1])
    if not known.any():
        return False
    growth = np.log(sizes[1:] / sizes[:-1])[known] / np.log(shown[1:] / shown[:-1])[known]
    return bool(np.median(growth) < 0.5)
