"""A Chronos on the rig: shots over its HTTP service, and everything that can go wrong with it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rigctl.config import parse
from rigctl.config.loading import default_path, read_toml
from rigctl.daemon import Daemon, open_daemon
from rigctl.errors import InterlockError
from rigctl.settings import ShotSettings
from tests.simulated import FRAMES_AFTER_MARK

SETTINGS = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)
CHRONOS = {
    "kind": "chronos", "url": "sim:chronos", "frame_rate_hz": 1000.0, "rows": 192, "columns": 240,
    "start_timeout_s": 1.0, "collect_timeout_s": 20.0, "answer_timeout_s": 1.0,
    "frames_before_mark": 5, "exposure_us": 100.0,
}  # fmt: skip
TO_THE_SPHERES = 120
"""Frames after the mark until the spheres have come into the picture."""


@pytest.fixture
def daemon(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Daemon]:
    """A rig with short films, or with so many frames after the mark as a test asks for."""
    document = read_toml(default_path())
    frames = getattr(request, "param", FRAMES_AFTER_MARK)
    document["camera"] = {**CHRONOS, "frames_after_mark": frames}
    document["store"] = {"folder": str(tmp_path / "data")}
    with open_daemon(parse(document, "chronos")) as opened:
        yield opened


@pytest.fixture
def laboratory(daemon: Daemon) -> Any:
    return daemon.laboratory


def fire(daemon: Daemon) -> Any:
    token = daemon.rig.arm(SETTINGS, "anna").token
    return daemon.rig.fire(token, token, "body", actor="anna")


@pytest.mark.parametrize("daemon", [TO_THE_SPHERES], indirect=True)
def test_a_shot_is_fetched_from_the_cameras_memory_and_shows_spheres_in_flight(
    daemon: Daemon,
) -> None:
    shot = fire(daemon)
    assert (shot.outcome, shot.fired, shot.frames, shot.lost) == ("stored", "yes", 125, 0)
    mine = daemon.store.frames(shot.id)
    assert (mine.pixels.shape, mine.pixels.dtype) == ((125, 192, 240), np.dtype(np.uint8))
    # Two spheres pass through the picture: it changes by far more than by the sensor's noise.
    noise = np.abs(np.diff(mine.pixels.astype(float), axis=0)).mean(axis=(1, 2)).min()
    assert change(mine.pixels) > 3 * noise


def change(pixels: Any) -> float:
    """Return the largest mean change of a picture against the first, in grey levels."""
    return float(np.abs(pixels.astype(float) - pixels[0]).mean(axis=(1, 2)).max())


@pytest.mark.parametrize(
    ("kind", "words"),
    [("silent", "no answer"), ("no-json", "JSON of a Chronos"), ("unplug", "nobody answers")],
)
def test_a_camera_that_is_not_there_or_is_something_else_refuses_the_arming(
    daemon: Daemon, laboratory: Any, kind: str, words: str
) -> None:
    laboratory.fault("chronos", kind)
    with pytest.raises(InterlockError) as refused:
        fire(daemon)
    assert any(s.startswith("camera:") and words in s for s in refused.value.tripped)
    assert laboratory.fires == 0
    if kind != "unplug":
        laboratory.clear_faults()
        assert fire(daemon).outcome == "stored"


@pytest.mark.parametrize(
    ("kind", "code"),
    [
        ("refuses", "device-answer"),
        ("never-records", "recording-not-confirmed"),
        ("other-size", "device-answer"),
    ],
)
def test_a_camera_that_does_not_record_as_told_fires_nothing_and_the_next_shot_works(
    daemon: Daemon, laboratory: Any, kind: str, code: str
) -> None:
    laboratory.fault("chronos", kind)
    shot = fire(daemon)
    assert (shot.outcome, shot.fired, shot.failure_code) == ("aborted", "no", code)
    assert laboratory.fires == 0
    next_works(daemon, laboratory)


@pytest.mark.parametrize("kind", ["lost-file", "damaged-file"])
def test_frames_that_are_not_whole_are_no_shot_and_the_next_one_works(
    daemon: Daemon, laboratory: Any, kind: str
) -> None:
    laboratory.fault("chronos", kind)
    shot = fire(daemon)
    assert (shot.outcome, shot.fired, shot.failure_code) == ("aborted", "yes", "frames")
    next_works(daemon, laboratory)


def next_works(daemon: Daemon, laboratory: Any) -> None:
    laboratory.clear_faults()
    if daemon.rig.status().latch_reason is not None:
        daemon.rig.release("anna", "the camera answers again")
    assert fire(daemon).outcome == "stored"
