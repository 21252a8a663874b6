"""Frames that are missing from a film whose times do not say so: where, how many, and the times."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats

MOST_LOST = 8
"""Frames at one place; where more are missing, the film is two."""


@dataclass(frozen=True, slots=True, order=True)
class Gap:
    """How many frames are missing before a frame."""

    frame: int
    count: int


def period_of(times_s: Floats) -> float:
    """Return the usual time from frame to frame, s."""
    return float(np.median(np.diff(times_s)))


def mended(times_s: Floats, gaps: Iterable[Gap]) -> Floats:
    """Return times of frames, s, with those of missing ones between them; shape (frames,)."""
    own, period = times_s.copy(), period_of(times_s)
    for gap in gaps:
        own[gap.frame :] += gap.count * period
    return own


def frame_at(times_s: Floats, time_s: float) -> float:
    """Return the frame number that a time has; beside the film its rate goes on."""
    period = period_of(times_s)
    last = len(times_s) - 1
    inside = float(np.interp(time_s, times_s, np.arange(last + 1)))
    beside = min(0.0, time_s - float(times_s[0])) + max(0.0, time_s - float(times_s[-1]))
    return inside + beside / period
