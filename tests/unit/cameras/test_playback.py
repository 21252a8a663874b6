"""Pictures digitised from playback: each from a frame that began after the tape had stepped."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rigctl.cameras.playback import DigitisedPlayback
from rigctl.cameras.v4l2 import VideoFrame
from rigctl.errors import DeviceSilentError, FramesError

Recorder = Any
Clock = Any


class Grabber:
    """30 frames a second of what the recorder shows; a frame shows what was on at its beginning."""

    name = "grabber"

    def __init__(self, recorder: Recorder, time: Clock) -> None:
        self.recorder, self.time, self.number = recorder, time, 0
        self.streams, self.released, self.checked = False, 0, 0

    def check(self) -> None:
        self.checked += 1

    def start(self) -> None:
        self.streams = True
        self.shown = -1

    def read(self, timeout_s: float) -> VideoFrame:
        assert self.streams
        if timeout_s < 1 / 30:
            raise DeviceSilentError("no frame", part=self.name)
        at_its_beginning, self.shown = self.shown, self.recorder.place_on_tape
        self.number += 1
        self.time.now += 1 / 30
        pixels = np.full((4, 5), at_its_beginning % 256, dtype=np.uint8)
        return VideoFrame(pixels, self.number, self.time.now, ())

    def stop(self) -> None:
        self.streams = False

    def close(self) -> None:
        self.released += 1


@pytest.fixture
def grabber(recorder: Recorder, time: Clock) -> Grabber:
    return Grabber(recorder, time)


@pytest.fixture
def playback(recorder: Recorder, grabber: Grabber, time: Clock) -> DigitisedPlayback:
    return DigitisedPlayback(
        recorder, grabber, picture_rate_hz=1000.0, clock=time.clock, wait=time.wait
    )


def test_each_picture_is_a_frame_that_began_after_the_step_and_keeps_its_tape_time(
    playback: DigitisedPlayback, grabber: Grabber
) -> None:
    frames = playback.fetch(812, 5, timeout_s=10.0)
    assert frames.sequence.tolist() == [812, 813, 814, 815, 816]
    assert frames.times_s.tolist() == [0.812, 0.813, 0.814, 0.815, 0.816]
    assert frames.pixels[:, 0, 0].tolist() == [n % 256 for n in range(812, 817)]
    assert not grabber.streams


def test_a_tape_that_shows_another_picture_is_an_error(
    playback: DigitisedPlayback, recorder: Recorder, grabber: Grabber
) -> None:
    recorder.step = lambda by: 0
    with pytest.raises(FramesError, match="found picture 812, allowed picture 813"):
        playback.fetch(812, 5, timeout_s=10.0)
    assert not grabber.streams


def test_a_tape_that_is_still_searching_at_the_bound_is_silence(
    playback: DigitisedPlayback, recorder: Recorder, time: Clock
) -> None:
    recorder.running = True
    recorder.started_at = time.now
    with pytest.raises(DeviceSilentError, match="did not reach the picture"):
        playback.fetch(812, 5, timeout_s=1.0)
    assert time.now == pytest.approx(1001.0, abs=0.05)


def test_a_grabber_that_is_too_slow_for_the_bound_is_silence(
    playback: DigitisedPlayback, grabber: Grabber
) -> None:
    with pytest.raises(DeviceSilentError):
        playback.fetch(812, 50, timeout_s=1.0)
    assert not grabber.streams


def test_a_sign_of_life_and_release_are_the_grabbers(
    playback: DigitisedPlayback, grabber: Grabber
) -> None:
    playback.check()
    playback.close()
    assert (grabber.checked, grabber.released) == (1, 1)
