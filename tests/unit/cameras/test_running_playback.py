"""A tape that plays on while a grabber takes it: every picture of a shot, under its number."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from analysis.imaging.playback.sampling import Sampling
from rigctl.cameras.playback import Crop, DigitisedPlayback, ResampledVideo
from rigctl.cameras.running_playback import RunningPlayback
from rigctl.cameras.v4l2 import VideoFrame
from rigctl.devices.ektapro import RecorderMode, RecorderStatus, TapePlace
from rigctl.errors import DeviceSilentError
from simulators.ektapro.grabber import FIELDS_PER_S, LINES, Grabber
from simulators.ektapro.processor import Processor
from simulators.ektapro.tape import RecordingFormat
from tests.playbacks import COLUMNS, ROWS, tape

Clock = Any
PICTURES = 40


class Link:
    """The simulated recorder behind the calls of its link."""

    name = "recorder"

    def __init__(self, time: Clock) -> None:
        self.processor = Processor(time.clock, run_up_s=0.1)
        self.processor.set_rate(RecordingFormat(1000, 1))
        self.processor.record()
        time.wait(0.1 + (PICTURES + 0.5) / 1000)
        self.processor.stop()
        self.search, self.step = self.processor.search, self.processor.step
        self.picture, self.play = self.processor.picture, self.processor.play
        self.stop = self.processor.stop

    def status(self) -> RecorderStatus:
        now = self.processor.status()
        mode = RecorderMode(str(now.mode))
        return RecorderStatus(mode, now.session, now.pictures, now.left_s, TapePlace.MIDDLE)


class Video:
    """The simulated grabber as a video device; some frames never come, by their numbers."""

    name = "grabber"

    def __init__(self, link: Link, time: Clock, skipped: frozenset[int] = frozenset()) -> None:
        recorded = tape(PICTURES + 5, seed=3)

        def shown(_: float) -> tuple[int, np.ndarray[Any, np.dtype[np.uint8]]]:
            number = link.picture()
            time.now += 1 / FIELDS_PER_S["pal"]
            return number, recorded[number]

        self.grabber, self.time, self.skipped = Grabber(shown, "pal"), time, skipped
        self.number, self.streams = 0, False

    def start(self) -> None:
        self.streams = True

    def read(self, timeout_s: float) -> VideoFrame:
        assert self.streams
        lost = []
        while True:
            self.number += 1
            began_at = self.time.now
            pixels = self.grabber.frames(1)[0][2]
            if self.number not in self.skipped:
                return VideoFrame(pixels, self.number, began_at, tuple(lost))
            lost.append(self.number)

    def check(self) -> None: ...

    def stop(self) -> None:
        self.streams = False

    def close(self) -> None: ...


def running(link: Link, video: Video, time: Clock) -> RunningPlayback:
    rows, columns = LINES["pal"]
    sampling = Sampling((0, 0, rows, columns), ROWS, COLUMNS, "top-first")
    still = ResampledVideo(video, Crop(0, 0, rows, columns), ROWS, COLUMNS)
    recorder: Any = link
    stepping = DigitisedPlayback(
        recorder, still, picture_rate_hz=1000.0, clock=time.clock, wait=time.wait
    )
    return RunningPlayback(
        recorder, video, sampling, stepping, picture_rate_hz=1000.0, clock=time.clock
    )


@pytest.mark.parametrize("skipped", [frozenset(), frozenset({8, 9, 20})])
def test_every_picture_of_a_shot_comes_under_its_number_whatever_the_grabber_skips(
    time: Clock, skipped: frozenset[int]
) -> None:
    link = Link(time)
    video = Video(link, time, skipped)
    frames = running(link, video, time).fetch(6, 25, timeout_s=30.0)
    recorded = np.array([picture.astype(float) for picture in tape(PICTURES + 5, seed=3)])
    assert frames.sequence.tolist() == list(range(6, 31))
    assert frames.times_s.tolist() == pytest.approx([n / 1000 for n in range(6, 31)])
    for number, pixels in zip(frames.sequence, frames.pixels, strict=True):
        assert np.square(recorded - pixels).mean(axis=(1, 2)).argmin() == number
    assert ("by steps" in frames.source) == bool(skipped)
    assert not video.streams


def test_a_shot_at_the_end_of_the_tape_is_whole(time: Clock) -> None:
    link = Link(time)
    frames = running(link, Video(link, time), time).fetch(PICTURES - 10, 10, timeout_s=30.0)
    assert frames.sequence.tolist() == list(range(PICTURES - 10, PICTURES))


def test_a_playback_that_does_not_end_in_time_is_silence(time: Clock) -> None:
    link = Link(time)
    video = Video(link, time)
    with pytest.raises(DeviceSilentError, match="did not end in time"):
        running(link, video, time).fetch(0, 30, timeout_s=0.5)
    assert not video.streams
