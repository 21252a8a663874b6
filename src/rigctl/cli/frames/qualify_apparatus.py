"""The apparatus of the qualification runs, loaded by name: nothing here knows simulators."""

from __future__ import annotations

import importlib
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.setup import CameraSetup, Environment, Setup, SphereSetup

APPARATUS = "simulators.qualification"

Frames = NDArray[np.uint8]
Rows = tuple[int, int]
Place = tuple[float, float]


class StageRun(Protocol):
    """Frames of a sphere on a stage, and how far it stood from its start, pixels."""

    frames: Frames
    moved_px: Floats


class FilmedDrop(Protocol):
    """Frames of a falling sphere at times in s, its diameter, and the true gravity."""

    frames: Frames
    times_s: Floats
    diameter_m: float
    gravity_m_per_s2: float


class TurningDisk(Protocol):
    """Frames of a turning disk, and its true angle from frame to frame, radians."""

    frames: Frames
    turn_rad: float


class Optics(Protocol):
    """What is known of the camera that films a shot."""

    rows: int
    columns: int
    scale_px_per_m: float
    front_rows: Rows
    top_rows: Rows
    front_origin_px: Place
    top_origin_px: Place
    exposure_s: float


class FilmedShot(Protocol):
    """Frames of a shot at times in s, with its camera and spheres."""

    frames: Frames
    times_s: Floats
    optics: Optics
    frame_rate_hz: float
    diameter_m: float
    gravity_m_per_s2: float


class Apparatus(Protocol):
    """What `APPARATUS` names."""

    def stage_run(self, direction: tuple[float, float], seed: int) -> StageRun:
        """Move a sphere in quarters of a pixel along (row, column)."""

    def filmed_drop(self, seed: int) -> FilmedDrop:
        """Let a sphere fall."""

    def turning_disk(self, seed: int) -> TurningDisk:
        """Turn a disk with markers."""

    def filmed_shot(self, number: int, seed: int) -> FilmedShot:
        """Fire two spheres at each other."""


def apparatus() -> Apparatus:
    """Return the simulated apparatus."""
    return cast("Apparatus", importlib.import_module(APPARATUS))


def setup_of(shot: FilmedShot) -> Setup:
    """Return what is known before a shot is measured."""
    optics = shot.optics
    camera = CameraSetup(
        frame_rate_hz=shot.frame_rate_hz,
        height_px=optics.rows,
        width_px=optics.columns,
        front_view_rows=optics.front_rows,
        top_view_rows=optics.top_rows,
        scale_px_per_m=optics.scale_px_per_m,
        front_origin_px=optics.front_origin_px,
        top_origin_px=optics.top_origin_px,
        exposure_s=optics.exposure_s,
    )
    spheres = (SphereSetup("a", shot.diameter_m), SphereSetup("b", shot.diameter_m))
    return Setup(camera, spheres, Environment(shot.gravity_m_per_s2))
