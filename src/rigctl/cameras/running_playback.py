"""Pictures from the tape while it plays: each field under the number of what it shows."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import groupby

import numpy as np

from analysis.imaging.fields import field_times
from analysis.imaging.playback.chain import Clock
from analysis.imaging.playback.recorded import Recorded, recorded_pictures
from analysis.imaging.playback.sampling import Sampling
from rigctl.cameras.frames import FrameSequence
from rigctl.cameras.playback import DigitisedPlayback, VideoSource
from rigctl.cameras.v4l2 import VideoFrame
from rigctl.devices.ektapro import EktaproLink
from rigctl.errors import DeviceSilentError

PLAYED_PER_S = 30.0
"""Pictures a second in normal playback (thesis, appendix A)."""
BEFORE, AFTER = 4, 2
"""Pictures played before and after those that are wanted: the ends tell less."""
ASKED_EACH = 8
"""Frames of the grabber between two questions where the tape is."""


class RunningPlayback:
    """A `PictureSource`: the tape plays at 30 pictures/s, and a grabber takes it as it runs.

    Television and tape run at rates of their own: some pictures are on two fields or more, some on
    none. Which picture a field shows follows from the fields themselves and the grabber's times.
    What is on no field, or on none with certainty, is brought by steps afterwards.

    Parameters
    ----------
    recorder, video
        The recorder, and the grabber on its video output, whole frames.
    sampling
        Where a frame holds the picture.
    stepping
        Brings a picture by a step of the tape.
    picture_rate_hz
        Pictures per second at which the tape was recorded.
    clock
        Monotonic seconds.
    """

    def __init__(
        self,
        recorder: EktaproLink,
        video: VideoSource,
        sampling: Sampling,
        stepping: DigitisedPlayback,
        *,
        picture_rate_hz: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._recorder, self._video, self._sampling = recorder, video, sampling
        self._stepping, self._rate, self._clock = stepping, picture_rate_hz, clock

    @property
    def name(self) -> str:
        """Grabber, as errors and manifests call it."""
        return f"running playback through {self._video.name}"

    def check(self) -> None:
        """See that the grabber is there."""
        self._video.check()

    def fetch(self, first: int, count: int, timeout_s: float) -> FrameSequence:
        """Play `count` pictures from number `first`, and put each field under its number.

        Raises
        ------
        DeviceSilentError
            Tape or grabber did not keep up within the time.
        FramesError
            The recorder shows another picture than it was told.
        DeviceError
            A device refused.
        """
        deadline = self._clock() + timeout_s
        begin = max(0, first - BEFORE)
        found = self._numbered(begin, self._played(begin, first + count + AFTER, deadline))
        wanted = range(first, first + count)
        pictures = {
            int(number): pixels
            for number, pixels in zip(found.numbers, found.pixels, strict=True)
            if int(number) in wanted
        }
        missing = [number for number in wanted if number not in pictures]
        for start, length in _runs(missing):
            more = self._stepping.fetch(start, length, deadline - self._clock())
            pictures |= dict(zip(more.sequence.tolist(), more.pixels, strict=True))
        sequence = np.arange(first, first + count, dtype=np.int64)
        return FrameSequence(
            pixels=np.stack([pictures[number] for number in wanted]),
            times_s=sequence / self._rate,
            sequence=sequence,
            lost=(),
            source=self._source(missing),
        )

    def close(self) -> None:
        """Release the grabber. Safe to call twice."""
        self._video.close()

    def _source(self, stepped: list[int]) -> str:
        """Return the name, and which pictures came by steps."""
        if not stepped:
            return self.name
        return f"{self.name}; not seen while it ran, by steps: {', '.join(map(str, stepped))}"

    def _played(self, begin: int, end: int, deadline: float) -> list[VideoFrame]:
        """Return the frames of a playback from its first picture, on which it stood, to `end`."""
        self._video.start()
        try:
            self._stepping.wind(begin, deadline - self._clock())
            stood_at = self._clock()
            frames = [self._read(deadline)]
            while frames[-1].time_s <= stood_at:
                frames = [self._read(deadline)]
            self._recorder.play()
            frames.append(self._read(deadline))
            while len(frames) % ASKED_EACH or self._is_playing(end):
                frames.append(self._read(deadline))
            self._recorder.stop()
        finally:
            self._video.stop()
        return frames

    def _read(self, deadline: float) -> VideoFrame:
        left_s = deadline - self._clock()
        if left_s <= 0:
            raise DeviceSilentError(
                "the playback did not end in time",
                part=self.name,
                todo="allow camera.collect_timeout_s at least 0.1 s a picture",
            )
        return self._video.read(left_s)

    def _is_playing(self, end: int) -> bool:
        """Say whether the tape is before a picture that it can still reach."""
        return self._recorder.picture() < min(end, self._recorder.status().pictures - 1)

    def _numbered(self, first: int, frames: list[VideoFrame]) -> Recorded:
        fields = [field for frame in frames for field in self._sampling.pictures(frame.pixels)]
        times_s = self._times_s(frames)
        return recorded_pictures(fields, times_s, Clock(PLAYED_PER_S, first, stands=True))

    def _times_s(self, frames: list[VideoFrame]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Return the time of each field by the driver's frame numbers: stamps tremble."""
        numbers = np.array([frame.number for frame in frames], dtype=np.float64)
        stamps = np.array([frame.time_s for frame in frames])
        period = float(np.polyfit(numbers, stamps - stamps[0], 1)[0])
        return field_times((numbers - numbers[0]) * period, self._sampling.fields, period)


def _runs(numbers: list[int]) -> list[tuple[int, int]]:
    """Return first and length of each run of neighbouring numbers."""
    groups = groupby(enumerate(numbers), lambda pair: pair[1] - pair[0])
    runs = [[number for _, number in group] for _, group in groups]
    return [(run[0], len(run)) for run in runs]
