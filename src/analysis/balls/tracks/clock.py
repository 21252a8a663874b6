"""Frames of a table in which something is seen, and when they were: by its times or by a rate."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.flight.flights import Ints
from analysis.balls.tracks.table import TrackTable
from analysis.errors import ShotRefusedError

MOST_FRAMES = 1_000_000
UNEVEN = 0.1
"""Of the time between frames, by which times lie off one rate: then they are numbered in order."""
ROUNDED = 0.75
"""Of the step to which times are rounded, by which they may lie off one rate."""
LEAST_FRAMES = 2
SAME_RATE = 0.02
"""By which the logarithms of two rates that are one may differ."""
LONGEST_STEP_S = 0.5
"""Between frames of any ball that bounces."""
NO_FRAMES = (
    "the table has neither frames nor times: each row counts as a frame; a row that is missing is "
    "not seen, and shifts the times after it"
)


@dataclass(frozen=True, slots=True, eq=False)
class Clock:
    """Frames in which something is seen.

    Attributes
    ----------
    numbers, times_s
        The table's numbers, and times, shape (frames,).
    index
        Which of them each place is in, shape (N,).
    notes
        How the times were read.
    """

    numbers: Floats
    times_s: Floats
    index: Ints
    notes: tuple[str, ...] = ()

    @property
    def period_s(self) -> float:
        """The usual time between frames."""
        return float(np.median(np.diff(self.times_s))) if len(self.times_s) > 1 else 1.0


def clock_of(table: TrackTable, rate_hz: float | None) -> Clock:
    """Return the frames of a table. Those in which nothing is seen are none, and need no place.

    Parameters
    ----------
    rate_hz
        Frames a second of the camera; None: by the table's times.

    Raises
    ------
    ShotRefusedError
        Frames are no whole numbers, or times lack, do not increase, or are in no s.
    """
    times = table.times_s
    if np.abs(table.frames - np.round(table.frames)).max() > 0.0:
        raise ShotRefusedError("frames", "frames of the table are no whole numbers")
    twice = times is not None and not table.numbered and _stand_twice(times, table.things)
    frames = table.frames if times is None or table.numbered or twice else _numbered(times)
    numbers, first, index = np.unique(frames, return_index=True, return_inverse=True)
    if len(numbers) > MOST_FRAMES:
        raise ShotRefusedError("frames", f"{len(numbers)} frames; {MOST_FRAMES} are read at most")
    if times is not None and twice and np.any(np.diff(times[first]) < 0):
        raise ShotRefusedError(
            "frames",
            "places of one thing have the same time; state frames, or times with more digits",
        )
    if rate_hz is not None:
        own = None if times is None else times[first]
        notes = tuple(_of_a_rate(table, own, rate_hz, twice=twice))
        return Clock(numbers, numbers / rate_hz, index, notes)
    if times is None or not table.states_times:
        said = "no times" if times is None else "times that are frame numbers"
        raise ShotRefusedError("frames", f"the table has {said}; state the rate with --fps")
    if len(numbers) < LEAST_FRAMES:
        raise ShotRefusedError("frames", "the table has places at one time only")
    if np.all(np.diff(times[first]) > 0):
        clock = Clock(numbers, times[first], index)
    else:
        own = _of_rounded(numbers, times[first])
        said = _rounded_said(times[first], 1.0 / float(np.median(np.diff(own))))
        clock = Clock(numbers, own, index, (said,))
    if not table.times_in and clock.period_s > LONGEST_STEP_S:
        raise ShotRefusedError("frames", _in_no_seconds(clock.period_s))
    return clock


def _of_a_rate(
    table: TrackTable, times: Floats | None, rate_hz: float, *, twice: bool
) -> Iterator[str]:
    """Say what a stated rate goes before, and what it hides."""
    if times is None:
        if not table.numbered:
            yield NO_FRAMES
        return
    if twice:
        yield _rounded_said(times, rate_hz)
    elif table.states_times and len(times) > 1:
        own = 1.0 / float(np.median(np.diff(times)))
        if abs(math.log(abs(own) / rate_hz)) > SAME_RATE:
            yield (
                f"the rate of {rate_hz:.5g} frames/s that is stated goes before the table's times, "
                f"by which it is {own:.5g}"
            )


def _in_no_seconds(step: float) -> str:
    return (
        f"times of the table go by steps of {step:.4g} and state no unit; in s that is "
        f"{1.0 / step:.2g} frames/s, and no bounce is seen so. State the rate with --fps, or the "
        "unit in the column's name, such as t (ms)"
    )


def _stand_twice(times: Floats, things: NDArray[np.str_]) -> bool:
    """Return whether places of one thing have the same time."""
    return len(set(zip(times.tolist(), things.tolist(), strict=True))) < len(things)


def _of_rounded(numbers: Floats, times: Floats) -> Floats:
    """Return times of one rate, of times that are rounded until several are the same."""
    middle = numbers.mean()
    slope, start = np.polyfit(numbers - middle, times, 1)
    found = start + slope * (numbers - middle)
    if slope <= 0 or np.abs(found - times).max() > ROUNDED * _step(times):
        raise ShotRefusedError(
            "frames",
            "times of the table do not increase with its frames, and are not those of one rate, "
            "rounded; state the rate with --fps, or times with more digits",
        )
    return np.asarray(found)


def _step(times: Floats) -> float:
    """Return to what times are rounded, s."""
    steps = np.diff(np.unique(times))
    return float(np.median(steps)) if len(steps) else 0.0


def _rounded_said(times: Floats, rate_hz: float) -> str:
    return (
        f"times of the table are rounded to {_step(times):.2g} s, and several are the same: frames "
        f"count in their order, at {rate_hz:.5g} frames/s; a row that is missing is not seen"
    )


def _numbered(times: Floats) -> Floats:
    """Return frame numbers from times; of times without one rate, their order."""
    each, index = np.unique(times, return_inverse=True)
    if len(each) < 2:
        return np.zeros(len(times))
    steps = (each - each[0]) / float(np.median(np.diff(each)))
    even = np.abs(steps - np.round(steps)).max() < UNEVEN
    if even and len(np.unique(np.round(steps))) == len(each):
        return np.asarray(np.round(steps)[index])
    return np.asarray(index, dtype=np.float64)
