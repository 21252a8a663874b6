"""A shot with a camera that records into its own memory, on a clock that the test turns."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rigctl.cameras.frames import FrameSequence
from rigctl.cameras.memory import MemoryCamera, MemoryCapture, Recorded
from rigctl.config import ChronosCamera
from rigctl.errors import DeviceSilentError, FramesError, RecordingNotConfirmedError

RATE = 1000.0


class FakeCamera:
    """Takes a frame every millisecond of the test's time, from the order to record on."""

    name = "camera"

    def __init__(self, time: Any) -> None:
        self.time, self.began, self.calls = time, 0.0, list[str]()
        self.records, self.holds, self.silent = True, 10**6, False
        self.asked: tuple[int, int] | None = None

    def check(self) -> None:
        self.calls.append("check")

    def start(self) -> None:
        if self.silent:
            raise DeviceSilentError("no answer", part=self.name)
        self.began = self.time.now

    def is_recording(self) -> bool:
        return self.records

    def end(self) -> Recorded:
        taken = int((self.time.now - self.began) * RATE) + 1
        return Recorded(min(taken, self.holds), self.began + (taken - 1) / RATE)

    def fetch(self, first: int, count: int, timeout_s: float) -> FrameSequence:
        self.asked = (first, count)
        sequence = np.arange(first, first + count)
        pixels = np.random.default_rng(1).integers(0, 256, (count, 192, 240)).astype(np.uint8)
        return FrameSequence(pixels, sequence / RATE, sequence, (), self.name)

    def stop(self) -> None:
        self.calls.append("stop")

    def close(self) -> None:
        self.calls.append("close")


@pytest.fixture
def camera(time: Any) -> FakeCamera:
    return FakeCamera(time)


@pytest.fixture
def capture(camera: FakeCamera, time: Any) -> MemoryCapture:
    settings = ChronosCamera(
        kind="chronos", url="http://camera", frame_rate_hz=RATE, rows=192, columns=240,
        start_timeout_s=3.0, collect_timeout_s=10.0, frames_before_mark=20, frames_after_mark=60,
    )  # fmt: skip
    return MemoryCapture(settings, camera, clock=time.clock, wait=time.wait)


def test_the_frames_about_the_fire_are_counted_back_from_the_last_one(
    camera: FakeCamera, capture: MemoryCapture, time: Any
) -> None:
    assert isinstance(camera, MemoryCamera)
    capture.start()
    time.now += 0.5
    fired = time.now - camera.began
    time.now += 0.030
    capture.mark(late_s=0.030)
    frames = capture.collect()
    assert camera.asked == (round(fired * RATE) - 20, 80)
    assert len(frames.sequence) == 80


def test_nothing_is_confirmed_before_the_frames_before_the_mark_are_taken(
    camera: FakeCamera, capture: MemoryCapture, time: Any
) -> None:
    capture.start()
    assert (time.now - camera.began) * RATE >= 20


def test_a_camera_that_never_records_is_not_confirmed_within_its_bound_and_is_stopped(
    camera: FakeCamera, capture: MemoryCapture, time: Any
) -> None:
    camera.records = False
    began = time.now
    with pytest.raises(RecordingNotConfirmedError, match="3 s"):
        capture.start()
    assert time.now - began < 3.1
    assert camera.calls == ["stop"]


def test_a_camera_that_goes_silent_at_the_start_is_stopped(
    camera: FakeCamera, capture: MemoryCapture
) -> None:
    camera.silent = True
    with pytest.raises(DeviceSilentError):
        capture.start()
    assert camera.calls == ["stop"]


def test_a_memory_that_does_not_reach_back_to_the_fire_is_no_shot(
    camera: FakeCamera, capture: MemoryCapture
) -> None:
    camera.holds = 50
    capture.start()
    capture.mark()
    with pytest.raises(FramesError, match="does not hold the whole shot"):
        capture.collect()


def test_a_recording_without_a_mark_is_no_shot(capture: MemoryCapture) -> None:
    capture.start()
    with pytest.raises(FramesError, match="no mark"):
        capture.collect()
