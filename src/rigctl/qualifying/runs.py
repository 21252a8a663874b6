"""What an accuracy run hands over to be measured: frames, and what is known of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.setup import Setup

Floats = NDArray[np.float64]
Frames = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class StageFrames:
    """A sphere at several places: frames (N, rows, columns), and where it stood (N, 2) in pixels.

    Displacements are (row, column) from the start.
    """

    frames: Frames
    moved_px: Floats


@dataclass(frozen=True, slots=True, eq=False)
class DropFrames:
    """A falling sphere: frames (N, rows, columns) at times (N,) in s, its diameter, and gravity."""

    frames: Frames
    times_s: Floats
    diameter_m: float
    gravity_m_per_s2: float


@dataclass(frozen=True, slots=True, eq=False)
class DiskFrames:
    """A turning disk: frames (N, rows, columns), and its turn from frame to frame in radians."""

    frames: Frames
    turn_rad: float


@dataclass(frozen=True, slots=True, eq=False)
class ShotFrames:
    """A shot of two spheres: frames (N, rows, columns) at times (N,) in s, and its set-up."""

    frames: Frames
    times_s: Floats
    setup: Setup
