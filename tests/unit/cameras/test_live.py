"""A streaming camera: frames at its rate confirm it, and each about the mark is accounted for."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from rigctl.cameras.live import LiveCapture
from rigctl.cameras.v4l2 import VideoFrame
from rigctl.config import V4l2Camera
from rigctl.errors import (
    DeviceAbsentError,
    DeviceSilentError,
    FramesError,
    RecordingNotConfirmedError,
    RigError,
)


def frame(number: int, *, rate: float = 500.0, lost: tuple[int, ...] = ()) -> VideoFrame:
    noise = np.random.default_rng(number).integers(0, 256, (8, 8), dtype=np.uint8)
    return VideoFrame(noise, number, 50.0 + number / rate, lost)


class Camera:
    """Gives the frames that the test puts in; says when all of them were read."""

    name = "camera"

    def __init__(self) -> None:
        self.frames: queue.Queue[VideoFrame | RigError] = queue.Queue()
        self.streams, self.checks, self.closes = False, 0, 0
        self._taken = threading.Condition()
        self._asked_again = 0

    def check(self) -> None:
        self.checks += 1

    def start(self) -> None:
        self.streams = True

    def stop(self) -> None:
        self.streams = False

    def close(self) -> None:
        self.closes += 1

    def read(self, timeout_s: float) -> VideoFrame:
        with self._taken:
            self._asked_again += 1
            self._taken.notify_all()
        try:
            found = self.frames.get(timeout=0.02)
        except queue.Empty:
            raise DeviceSilentError("no frame", part=self.name) from None
        if isinstance(found, RigError):
            raise found
        return found

    def put(self, *frames: VideoFrame) -> None:
        for each in frames:
            self.frames.put(each)

    def settle(self) -> None:
        """Return once every frame put in so far was read and the next one asked for."""
        with self._taken:
            done = self._asked_again
            assert self._taken.wait_for(
                lambda: self.frames.empty() and self._asked_again > done + 1, timeout=60.0
            )


def settings(**changes: object) -> V4l2Camera:
    values: dict[str, object] = {
        "kind": "v4l2", "device": "/dev/video0", "frame_rate_hz": 500.0, "rows": 8, "columns": 8,
        "start_timeout_s": 60.0, "collect_timeout_s": 60.0, "frames_before_mark": 2,
        "frames_after_mark": 5,
    }  # fmt: skip
    return V4l2Camera.model_validate(values | changes)


Build = Callable[..., tuple[LiveCapture, Camera]]


@pytest.fixture
def build() -> Iterator[Build]:
    made: list[LiveCapture] = []

    def make(**changes: object) -> tuple[LiveCapture, Camera]:
        camera = Camera()
        made.append(LiveCapture(settings(**changes), camera, clock=lambda: 77.0))
        return made[-1], camera

    yield make
    for capture in made:
        capture.close()


def started(build: Build, **changes: object) -> tuple[LiveCapture, Camera]:
    """Start on frames 0 to 19 and wait until all were read."""
    capture, camera = build(**changes)
    camera.put(*map(frame, range(20)))
    capture.start()
    camera.settle()
    return capture, camera


def test_frames_at_the_configured_rate_confirm_the_recording(build: Build) -> None:
    capture, camera = build()
    camera.put(*map(frame, range(20)))
    confirmation = capture.start()
    assert (confirmation.by, confirmation.at) == ("camera", 77.0)
    assert "500.0 /s" in confirmation.evidence


def test_the_shot_is_the_frames_about_the_mark(build: Build) -> None:
    capture, camera = started(build)
    capture.mark()
    camera.put(*map(frame, range(20, 40)))
    frames = capture.collect()
    assert frames.sequence.tolist() == [18, 19, 20, 21, 22, 23, 24]
    assert frames.times_s[0] == pytest.approx(50.0 + 18 / 500)
    assert frames.lost == ()
    assert not camera.streams


def test_a_mark_that_came_late_is_counted_back_to_the_fire(build: Build) -> None:
    capture, camera = started(build)
    capture.mark(late_s=10 / 500)
    camera.put(*map(frame, range(20, 40)))
    assert capture.collect().sequence.tolist() == [8, 9, 10, 11, 12, 13, 14]


def test_frames_that_the_camera_lost_about_the_mark_are_named_and_others_are_not(
    build: Build,
) -> None:
    capture, camera = started(build)
    capture.mark()
    camera.put(frame(20), frame(22, lost=(21,)), frame(23), frame(26, lost=(24, 25)))
    frames = capture.collect()
    assert frames.sequence.tolist() == [18, 19, 20, 22, 23]
    assert frames.lost == (21, 24)


def test_too_few_frames_within_the_bound_are_an_error(build: Build) -> None:
    capture, camera = started(build, collect_timeout_s=0.3)
    capture.mark()
    camera.put(*map(frame, range(20, 23)))
    camera.settle()
    with pytest.raises(FramesError, match=r"did not come \(found frame 22, allowed 0\.3 s\)"):
        capture.collect()


def test_a_shot_without_a_mark_is_an_error(build: Build) -> None:
    capture, _ = started(build, collect_timeout_s=0.1)
    with pytest.raises(FramesError):
        capture.collect()


@pytest.mark.parametrize("rate", [440.0, 560.0])
def test_frames_at_another_rate_are_no_confirmation(build: Build, rate: float) -> None:
    capture, camera = build(start_timeout_s=1.0)
    camera.put(*(frame(number, rate=rate) for number in range(30)))
    with pytest.raises(RecordingNotConfirmedError, match=f"{rate:.1f} frames/s, allowed 500"):
        capture.start()
    assert not camera.streams


def test_silence_is_no_confirmation_within_the_bound(build: Build) -> None:
    capture, _ = build(start_timeout_s=0.2)
    with pytest.raises(RecordingNotConfirmedError, match="0 frames"):
        capture.start()


def test_time_stamps_that_stand_still_are_no_confirmation(build: Build) -> None:
    capture, camera = build(start_timeout_s=0.2)
    camera.put(*(VideoFrame(frame(n).pixels, n, 50.0, ()) for n in range(20)))
    with pytest.raises(RecordingNotConfirmedError):
        capture.start()


def test_a_camera_that_fails_at_the_start_is_no_confirmation_and_is_named_as_the_cause(
    build: Build,
) -> None:
    capture, camera = build()
    camera.frames.put(DeviceAbsentError("gone", part="camera"))
    with pytest.raises(RecordingNotConfirmedError) as caught:
        capture.start()
    assert isinstance(caught.value.__cause__, DeviceAbsentError)


def test_a_camera_that_fails_after_the_mark_is_named(build: Build) -> None:
    capture, camera = started(build)
    capture.mark()
    camera.frames.put(DeviceAbsentError("gone", part="camera"))
    with pytest.raises(DeviceAbsentError, match="gone"):
        capture.collect()


def test_memory_stays_the_same_however_long_the_camera_streams(build: Build) -> None:
    capture, camera = started(build)
    camera.put(*map(frame, range(20, 500)))
    camera.settle()
    held = len(capture._kept)
    camera.put(*map(frame, range(500, 900)))
    camera.settle()
    assert len(capture._kept) == held < 500
    capture.mark()
    camera.put(*map(frame, range(900, 1300)))
    camera.settle()
    assert len(capture._kept) == held + 5


def test_a_frozen_camera_is_an_error(build: Build) -> None:
    capture, camera = started(build)
    capture.mark()
    still = frame(0).pixels
    camera.put(*(VideoFrame(still, n, 50.0 + n / 500, ()) for n in range(20, 40)))
    with pytest.raises(FramesError, match="equals the one before"):
        capture.collect()


def test_shot_follows_shot_and_a_sign_of_life_does_not_disturb_a_stream(build: Build) -> None:
    capture, camera = started(build)
    capture.check()
    assert camera.checks == 0
    capture.stop()
    capture.check()
    assert camera.checks == 1
    camera.put(*map(frame, range(100, 120)))
    capture.start()
    camera.settle()
    capture.mark()
    camera.put(*map(frame, range(120, 140)))
    assert capture.collect().sequence.tolist()[0] == 118
