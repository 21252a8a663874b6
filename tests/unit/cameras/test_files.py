"""The capture folder: a stack counts once its description is there, and never for ever."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile

from rigctl.cameras.capture_folder import CaptureFolder
from rigctl.errors import DeviceAbsentError, DeviceAnswerError, FramesError

Recorder = Any
Clock = Any


@pytest.fixture
def folder(tmp_path: Path, recorder: Recorder, time: Clock) -> CaptureFolder:
    return CaptureFolder(
        tmp_path, recorder=recorder, picture_rate_hz=1000.0, clock=time.clock, wait=time.wait
    )


def put(path: Path, first: int, count: int, name: str, *, described: bool = True) -> None:
    """What a digitiser leaves: the stack, and the description last."""
    pixels = np.random.default_rng(first).integers(0, 256, (count, 8, 8), dtype=np.uint8)
    tifffile.imwrite(path / f"{name}.tiff", pixels, photometric="minisblack", metadata=None)
    if described:
        numbers = list(range(first, first + count))
        note = {"frames": count, "rows": 8, "columns": 8, "frame_rate_hz": 1000.0,
                "sequence": numbers, "times_s": [n / 1e3 for n in numbers], "lost": []}  # fmt: skip
        (path / f"{name}.json").write_text(json.dumps(note))


def test_pictures_are_read_once_their_description_appears(
    tmp_path: Path, folder: CaptureFolder, recorder: Recorder, time: Clock
) -> None:
    pending: list[Callable[[], None]] = []
    recorder.on_transfer = lambda *what: pending.append(lambda: put(tmp_path, *what))
    waits = 0

    def wait(seconds: float) -> None:
        nonlocal waits
        waits += 1
        time.now += seconds
        if waits == 3:
            pending.pop()()

    folder._wait = wait
    frames = folder.fetch(5, 4, timeout_s=1.0)
    assert frames.sequence.tolist() == [5, 6, 7, 8]
    assert waits == 3


def test_a_stack_without_its_description_is_waited_for_no_longer_than_the_bound(
    tmp_path: Path, folder: CaptureFolder, recorder: Recorder, time: Clock
) -> None:
    recorder.on_transfer = lambda *what: put(tmp_path, *what, described=False)
    with pytest.raises(FramesError, match=r"no frames came \(limit 1 s\)"):
        folder.fetch(5, 4, timeout_s=1.0)
    assert time.now == pytest.approx(1001.0, abs=0.02)


def test_every_stack_has_a_name_of_its_own_and_goes_when_the_next_is_asked_for(
    tmp_path: Path, folder: CaptureFolder, recorder: Recorder
) -> None:
    (tmp_path / "of-another.json").write_text("{}")
    recorder.on_transfer = lambda *what: put(tmp_path, *what)
    folder.fetch(5, 2, timeout_s=1.0)
    first = set(tmp_path.glob("rig-*"))
    folder.fetch(5, 2, timeout_s=1.0)
    second = set(tmp_path.glob("rig-*"))
    assert len(first) == len(second) == 2
    assert not first & second
    assert (tmp_path / "of-another.json").exists()


def test_a_refused_transfer_is_the_recorders_error(
    folder: CaptureFolder, recorder: Recorder
) -> None:
    recorder.refuses.add("transfer")
    with pytest.raises(DeviceAnswerError, match="transfer was refused"):
        folder.fetch(5, 2, timeout_s=1.0)


def test_a_folder_that_is_not_there_is_absent(tmp_path: Path, recorder: Recorder) -> None:
    there = CaptureFolder(tmp_path, recorder=recorder, picture_rate_hz=1000.0)
    there.check()
    gone = CaptureFolder(tmp_path / "gone", recorder=recorder, picture_rate_hz=1000.0)
    with pytest.raises(DeviceAbsentError, match="gone"):
        gone.check()
    gone.close()
