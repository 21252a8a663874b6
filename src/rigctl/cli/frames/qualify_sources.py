"""Where the frames of an accuracy run come from: simulated, files, or the parts of a rig."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.setup import CameraSetup, Environment, Setup, SphereSetup
from rigctl.errors import ConfigurationError, SettingsError
from rigctl.qualifying import runs
from rigctl.qualifying.runs import DiskFrames, DropFrames, ShotFrames, StageFrames

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


FALLS_OF_A_RIG = 3


@dataclass(frozen=True, slots=True)
class Source:
    """Files, or a configuration, or neither: then all is simulated.

    `stated` is what a person said of the frames.
    """

    frames: tuple[Path, ...] = ()
    config: Path | None = None
    stated: float | None = None

    @property
    def simulated(self) -> bool:
        """Whether frames are rendered here and now."""
        return not self.frames and self.config is None

    @property
    def name(self) -> str:
        """Files or configuration."""
        return ", ".join(map(str, self.frames or (self.config,)))

    def need(self) -> float:
        """Return what was stated; `chosen_source` has seen to it for files."""
        if self.stated is None:
            raise SettingsError("is not stated", part="--frames", todo="state it")
        return self.stated


@dataclass(frozen=True, slots=True)
class Falling:
    """What is known of falls beside their frames, and how many a rig fires or a world renders."""

    gravity_m_per_s2: float
    rate_hz: float | None
    fired: int
    simulated: int


def chosen_source(
    frames: Sequence[Path] | None, config: Path | None, stated: Mapping[str, float | None]
) -> Source:
    """Return where frames come from.

    Parameters
    ----------
    stated
        The option that frames need, and its value.

    Raises
    ------
    SettingsError
        Both frames and a configuration, frames without what they need, or that without frames.
    """
    if frames and config is not None:
        raise SettingsError(
            "and --frames exclude each other", part="--config", todo="give one of them"
        )
    for option, value in stated.items():
        if frames and value is None:
            raise SettingsError("is needed with --frames", part=option, todo="state it")
        if value is not None and not frames:
            raise SettingsError(
                "is for frames of your own", part=option, value=f"{value:g}", todo="add --frames"
            )
    return Source(tuple(frames or ()), config, next(iter(stated.values()), None))


def stages(
    source: Source, direction: str, seed: int, simulated: Sequence[tuple[float, float]]
) -> Iterator[StageFrames]:
    """Give one run for each file, or that of the configuration's slide, or the simulated ones."""
    if source.config is not None:
        # Camera and slide are loaded only where they act.
        from rigctl.config.bench import load_bench  # noqa: PLC0415
        from rigctl.qualifying.bench import opened, record_stage  # noqa: PLC0415

        bench = load_bench(source.config)
        with TemporaryDirectory() as folder, opened(bench, Path(folder)) as (capture, slide):
            if slide is None:
                raise _other(source.config, "stage")
            yield record_stage(bench, capture, slide)
        return
    if source.frames:
        step = source.need()
        way = (step * ("y" in direction), step * ("x" in direction))
        yield from (runs.stage_frames(path, way) for path in source.frames)
        return
    for own in simulated:
        run = apparatus().stage_run(own, seed)
        yield StageFrames(run.frames, run.moved_px)


def falls(source: Source, known: Falling, seed: int) -> Sequence[DropFrames]:
    """Return one run for each file, or for each shot that the configuration's rig fires."""
    if source.config is not None:
        from rigctl.qualifying.bench import fired_drops  # noqa: PLC0415

        return fired_drops(source.config, known.fired)
    if source.frames:
        diameter_m = 1e-3 * source.need()
        return [
            runs.drop_frames(path, diameter_m, known.gravity_m_per_s2, known.rate_hz)
            for path in source.frames
        ]
    first = known.simulated * seed
    filmed = [apparatus().filmed_drop(first + k) for k in range(known.simulated)]
    return [
        DropFrames(one.frames, one.times_s, one.diameter_m, one.gravity_m_per_s2) for one in filmed
    ]


def disk(source: Source, rate_hz: float | None, seed: int) -> tuple[DiskFrames, float | None]:
    """Return the frames of a disk, and the frame rate where it is known."""
    if source.config is not None:
        from rigctl.config.bench import load_bench  # noqa: PLC0415
        from rigctl.qualifying.bench import opened, record_disk  # noqa: PLC0415

        bench = load_bench(source.config)
        if bench.disk is None:
            raise _other(source.config, "disk")
        with TemporaryDirectory() as folder, opened(bench, Path(folder)) as (capture, _):
            return record_disk(bench, capture), bench.camera.picture_rate_hz
    if source.frames:
        if len(source.frames) > 1:
            raise SettingsError(
                "is one film of a disk",
                part="--frames",
                value=f"{len(source.frames)} paths",
                limit="1",
                todo="measure one after another",
            )
        return runs.disk_frames(source.frames[0], source.need(), rate_hz), rate_hz
    turning = apparatus().turning_disk(seed)
    return DiskFrames(turning.frames, turning.turn_rad), None


def shots(source: Source, seed: int, simulated: int) -> Iterator[ShotFrames]:
    """Give shots of two spheres with their set-ups."""
    if source.frames:
        yield from runs.shot_frames(source.frames)
        return
    for number in range(simulated):
        filmed = apparatus().filmed_shot(number, seed)
        yield ShotFrames(filmed.frames, filmed.times_s, setup_of(filmed))


def _other(config: Path, wanted: str) -> ConfigurationError:
    return ConfigurationError(
        f"describes no {wanted}", part=str(config), todo="name the file of another apparatus"
    )
