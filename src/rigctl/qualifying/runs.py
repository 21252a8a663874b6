"""What an accuracy run hands over to be measured, and such runs from files: frames and context."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.arrays import Floats, Grey
from analysis.balls.films.frames import read_frames
from analysis.campaign import DESCRIPTION, read_campaign, read_job
from analysis.errors import InputError
from analysis.qualification.drop import whole_falls
from analysis.setup import Setup
from rigctl.errors import AnalysisInputError, SettingsError
from rigctl.measuring.stored_shot import read_stored_shot


@dataclass(frozen=True, slots=True, eq=False)
class StageFrames:
    """A sphere at several places: frames (N, rows, columns), and where it stood (N, 2) in pixels.

    Displacements are (row, column) from the start.
    """

    frames: Grey
    moved_px: Floats


@dataclass(frozen=True, slots=True, eq=False)
class DropFrames:
    """A falling sphere: frames (N, rows, columns) at times (N,) in s, its diameter, and gravity."""

    frames: Grey
    times_s: Floats
    diameter_m: float
    gravity_m_per_s2: float


@dataclass(frozen=True, slots=True, eq=False)
class DiskFrames:
    """A turning disk: frames (N, rows, columns), and its turn from frame to frame in radians."""

    frames: Grey
    turn_rad: float


@dataclass(frozen=True, slots=True, eq=False)
class ShotFrames:
    """A shot of two spheres: frames (N, rows, columns) at times (N,) in s, and its set-up."""

    frames: Grey
    times_s: Floats
    setup: Setup


MANIFEST = "manifest.json"
"""What the folder of a stored shot holds beside its frames."""

Film = tuple[Grey, Floats | None]
"""Frames, and their times from the first, s, where the file knows them."""


def stage_frames(path: Path, step_px: tuple[float, float]) -> StageFrames:
    """Read one picture for each place of the stage, equal steps of (row, column) apart."""
    frames, _ = _film(path)
    return StageFrames(frames, np.outer(np.arange(len(frames)), step_px))


def drop_frames(
    path: Path, diameter_m: float, gravity_m_per_s2: float, rate_hz: float | None
) -> DropFrames:
    """Read a fall; what counts are the frames that show the whole sphere."""
    frames, times = _timed(path, rate_hz)
    part = whole_falls(frames)
    return DropFrames(frames[part], times[part], diameter_m, gravity_m_per_s2)


def disk_frames(path: Path, rate_rpm: float, rate_hz: float | None) -> DiskFrames:
    """Read frames of a disk that turns at a known rate."""
    frames, times = _timed(path, rate_hz)
    if len(frames) < 2:
        raise AnalysisInputError("holds a single frame, 2 are needed", part=str(path))
    turn = 2.0 * math.pi * rate_rpm / 60.0
    return DiskFrames(frames, turn * float(np.median(np.diff(times))))


def shot_frames(paths: Sequence[Path]) -> Iterator[ShotFrames]:
    """Read shots of campaign folders, or of a store, each with the set-up that it came with."""
    for path in paths:
        if (path / MANIFEST).exists():
            yield ShotFrames(*_stored(path))
            continue
        try:
            if not (path / DESCRIPTION).exists():
                raise InputError(path, f"holds neither {DESCRIPTION} nor {MANIFEST}")
            for job in read_campaign(path).jobs:
                read = read_job(job)
                yield ShotFrames(read.frames, read.times_s, read.setup)
        except InputError as error:
            raise AnalysisInputError(error.reason, part=error.path) from error


def _timed(path: Path, rate_hz: float | None) -> tuple[Grey, Floats]:
    frames, times = _film(path)
    if rate_hz is not None:
        return frames, np.arange(len(frames)) / rate_hz
    if times is None:
        raise SettingsError(
            "the file says no times of its frames", part=str(path), todo="state --fps"
        )
    return frames, times


def _film(path: Path) -> Film:
    if (path / MANIFEST).exists():
        frames, times, _ = _stored(path)
        return frames, times
    try:
        stack = read_frames(path)
    except InputError as error:
        raise AnalysisInputError(error.reason, part=error.path) from error
    return stack.light, stack.times_s


def _stored(folder: Path) -> tuple[Grey, Floats, Setup]:
    try:
        return read_stored_shot(folder)
    except (KeyError, OSError, ValueError) as error:
        raise AnalysisInputError(f"is no stored shot: {error}", part=str(folder)) from error
