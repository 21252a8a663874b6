"""Noise that all numbers of a frame share, because its time is uncertain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.effects.clock import timing_jitter

FRAME = 12
"""Numbers of a frame: positions and orientations of two spheres."""


@dataclass(frozen=True, slots=True, eq=False)
class Jitter:
    """A random error of each frame's time, of one standard deviation.

    Attributes
    ----------
    along
        Whitened change of the prediction with time, 1/s, shape (S, F, 2, 6).
    sigma_s
        Standard deviation, s.
    """

    along: Floats
    sigma_s: float

    def whiten(self, columns: Floats) -> Floats:
        """Whiten columns by spheres and kinds (S, 4, 3 F, K) by frames instead, (S, 1, 12 F, K)."""
        return self.whiten_frames(by_frame(columns))[:, None]

    def whiten_frames(self, columns: Floats) -> Floats:
        """Whiten columns by frames, (S, 12 F, K)."""
        shots, frames = self.along.shape[:2]
        along = self.along.reshape(shots, frames, FRAME)
        return timing_jitter.whiten(columns, along, np.array([self.sigma_s]))


def by_frame(columns: Floats) -> Floats:
    """Sort columns by spheres and kinds (S, 4, 3 F, K) by frames, (S, 12 F, K)."""
    shots, kinds, length, count = columns.shape
    parted = columns.reshape(shots, kinds, length // 3, 3, count)
    return np.swapaxes(parted, 1, 2).reshape(shots, kinds * length, count)


def by_kind(columns: Floats) -> Floats:
    """Sort columns by frames (S, 12 F, K) by spheres and kinds, (S, 4, 3 F, K)."""
    shots, length, count = columns.shape
    frames, kinds = length // FRAME, FRAME // 3
    parted = columns.reshape(shots, frames, kinds, 3, count)
    return np.swapaxes(parted, 1, 2).reshape(shots, kinds, 3 * frames, count)


def turning_by_frame(frames: int) -> NDArray[np.bool_]:
    """Return which of the numbers of all frames are of orientations, shape (1, 12 F)."""
    return np.tile(np.repeat([False, True], 3), 2 * frames)[None]
