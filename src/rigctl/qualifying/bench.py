"""Accuracy runs recorded by a rig's own parts: camera and slide, or falls that a magnet lets go."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np

from analysis.qualification.drop import whole_falls
from rigctl import local
from rigctl.cameras.build import build_capture
from rigctl.cameras.capture import Capture
from rigctl.cameras.frames import FrameSequence
from rigctl.config import load
from rigctl.config.bench import Bench, StageSection
from rigctl.devices.build import build_slide
from rigctl.devices.roles import Slide
from rigctl.errors import ConfigurationError, DeviceSilentError, FramesError
from rigctl.laboratory import open_laboratory
from rigctl.qualifying.runs import DiskFrames, DropFrames, StageFrames
from rigctl.settings import ShotSettings

_POLL_S = 0.02
LOST_TODO = "record once more: a turn across a lost frame would count for two"


@contextmanager
def opened(bench: Bench, folder: Path) -> Iterator[tuple[Capture, Slide | None]]:
    """Open camera and slide; `folder` is for the simulated laboratory.

    Raises
    ------
    ConfigurationError
        The simulated laboratory cannot be.
    DeviceError
        A device is absent, busy or forbidden.
    """
    with ExitStack() as opening:
        laboratory = open_laboratory(bench.simulation, bench.scene, folder)
        if laboratory is not None:
            opening.callback(laboratory.close)
        capture = build_capture(bench.camera, laboratory)
        opening.callback(capture.close)
        slide = None if bench.slide is None else build_slide(bench.slide, laboratory)
        if slide is not None:
            opening.callback(slide.close)
        yield capture, slide


def record_disk(bench: Bench, capture: Capture) -> DiskFrames:
    """Record the turning disk.

    Raises
    ------
    DeviceError, FramesError, RecordingNotConfirmedError
        The camera did not record, or lost a frame.
    """
    if bench.disk is None:
        raise ConfigurationError("describes no disk", part=bench.name, todo="name another file")
    frames = _recorded(capture)
    interval_s = float(np.median(np.diff(frames.times_s)))
    return DiskFrames(frames.pixels, 2.0 * math.pi * bench.disk.rate_rpm / 60.0 * interval_s)


def record_stage(
    bench: Bench, capture: Capture, slide: Slide, wait: Callable[[float], None] = time.sleep
) -> StageFrames:
    """Move the slide step by step and take a picture at each place; it stays at the last.

    Raises
    ------
    DeviceError, FramesError, RecordingNotConfirmedError
        A part did not do its work.
    """
    if bench.stage is None:
        raise ConfigurationError("describes no stage", part=bench.name, todo="name another file")
    places, pictures = [], []
    for number in range(bench.stage.steps + 1):
        aim_mm = bench.stage.start_mm + number * bench.stage.step_mm
        places.append(_stand(slide, aim_mm, bench.stage, wait))
        pictures.append(_recorded(capture).pixels[0])
    steps = (np.array(places) - places[0]) / bench.stage.step_mm
    return StageFrames(np.stack(pictures), np.outer(steps, bench.stage.step_px))


def _recorded(capture: Capture) -> FrameSequence:
    capture.start()
    try:
        capture.mark()
        frames = capture.collect()
    finally:
        capture.stop()
    if frames.lost:
        raise FramesError(
            "frames were lost",
            part=capture.name,
            value=", ".join(map(str, frames.lost)),
            limit="none",
            todo=LOST_TODO,
        )
    return frames


def _stand(
    slide: Slide, aim_mm: float, section: StageSection, wait: Callable[[float], None]
) -> float:
    """Move, and return where the slide says that it stands, mm."""
    slide.move_to(aim_mm)
    left_s = section.settle_timeout_s
    while True:
        if not slide.is_moving():
            stands_mm = slide.position().value
            if abs(stands_mm - aim_mm) <= section.tolerance_mm:
                return stands_mm
        if left_s <= 0.0:
            slide.stop()
            raise DeviceSilentError(
                f"the slide did not reach {aim_mm:g} mm",
                part=slide.name,
                limit=f"{section.settle_timeout_s:g} s",
                todo="check slide and stage.tolerance_mm",
            )
        wait(_POLL_S)
        left_s -= _POLL_S


NOTHING_SET = ShotSettings(pressure_a_kpa=0.0, pressure_b_kpa=0.0, offset_mm=0.0)
"""A magnet has neither pressure nor offset."""


def fired_drops(config: Path, count: int) -> list[DropFrames]:
    """Fire shots one after another; each is kept in the store as any other.

    Raises
    ------
    ConfigurationError
        The apparatus is none that drops a sphere.
    RigError
        The rig refused, or a shot came without frames.
    ShotRefusedError
        Frames do not show a whole sphere for long enough.
    """
    section = load(config)
    if section.apparatus != "drop":
        raise ConfigurationError(
            "drops no sphere",
            part=str(config),
            value=f"apparatus = {section.apparatus!r}",
            limit="drop",
            todo="name the file of another apparatus",
        )
    diameter, gravity = section.spheres[0].diameter_m, section.environment.gravity_m_per_s2
    runs = []
    with local.opened(config) as rig:
        for _ in range(count):
            frames, times_s = rig.filmed(NOTHING_SET)
            part = whole_falls(frames)
            runs.append(DropFrames(frames[part], times_s[part], diameter, gravity))
    return runs
