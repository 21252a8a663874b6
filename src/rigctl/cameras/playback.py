"""Pictures from the tape by stepping through it and digitising the still image."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import cv2
import numpy as np
from numpy.typing import NDArray

from rigctl.cameras.frames import FrameSequence
from rigctl.cameras.v4l2 import VideoFrame
from rigctl.devices.ektapro import EktaproLink, RecorderMode
from rigctl.errors import DeviceSilentError, FramesError

_POLL_S = 0.02


@runtime_checkable
class VideoSource(Protocol):
    """A device that gives frames one after another."""

    @property
    def name(self) -> str:
        """The device."""

    def check(self) -> None:
        """Raise a `RigError` when the device is not there."""

    def start(self) -> None:
        """Begin to stream."""

    def read(self, timeout_s: float) -> VideoFrame:
        """Return the next whole frame, or raise within the time."""

    def stop(self) -> None:
        """Stop streaming; harmless when nothing streams."""

    def close(self) -> None:
        """Release the device. Safe to call twice."""


class DigitisedPlayback:
    """A `PictureSource`: the recorder shows one picture after another, a grabber takes each.

    Every picture keeps its number on the tape, and its time is that number divided by the
    recording rate; the grabber's own numbers and times serve only to tell a frame taken after
    the tape has stepped from one taken before.

    Parameters
    ----------
    recorder, video
        The recorder, and the grabber on its video output.
    picture_rate_hz
        Pictures per second at which the tape was recorded.
    clock, wait
        Monotonic seconds, of the same clock as the grabber's time stamps, and a wait in seconds.
    """

    def __init__(
        self,
        recorder: EktaproLink,
        video: VideoSource,
        *,
        picture_rate_hz: float,
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self._recorder, self._video, self._rate = recorder, video, picture_rate_hz
        self._clock, self._wait = clock, wait

    @property
    def name(self) -> str:
        """Grabber, as errors and manifests call it."""
        return f"playback through {self._video.name}"

    def check(self) -> None:
        """See that the grabber is there."""
        self._video.check()

    def fetch(self, first: int, count: int, timeout_s: float) -> FrameSequence:
        """Show `count` pictures from number `first`, and digitise each.

        Raises
        ------
        FramesError
            The recorder shows another picture than it was told.
        DeviceSilentError
            Tape or grabber did not keep up within the time.
        DeviceError
            A device refused.
        """
        deadline = self._clock() + timeout_s
        self._video.start()
        try:
            self.wind(first, timeout_s)
            pixels = []
            for number in range(first, first + count):
                if number > first:
                    self._recorder.step(+1)
                self._require(number)
                pixels.append(self._still(deadline, timeout_s).pixels)
        finally:
            self._video.stop()
        sequence = np.arange(first, first + count, dtype=np.int64)
        return FrameSequence(np.stack(pixels), sequence / self._rate, sequence, (), self.name)

    def close(self) -> None:
        """Release the grabber. Safe to call twice."""
        self._video.close()

    def wind(self, number: int, timeout_s: float) -> None:
        """Wind the tape to a picture and wait until it stands there.

        Raises
        ------
        DeviceSilentError
            It does not within the time.
        """
        deadline = self._clock() + timeout_s
        self._recorder.search(number)
        while self._recorder.status().mode is not RecorderMode.STOP:
            if self._clock() >= deadline:
                raise self._late("the tape did not reach the picture", timeout_s)
            self._wait(_POLL_S)

    def _require(self, number: int) -> None:
        shown = self._recorder.picture()
        if shown != number:
            raise FramesError(
                "the recorder shows another picture than it was told",
                part=self.name,
                value=f"picture {shown}",
                limit=f"picture {number}",
                todo="check the tape",
            )

    def _still(self, deadline: float, timeout_s: float) -> VideoFrame:
        stepped_at = self._clock()
        fresh = 0
        while (left_s := deadline - self._clock()) > 0:
            frame = self._video.read(left_s)
            fresh += frame.time_s > stepped_at
            # The first frame after the step may have begun before it; the second has not.
            if fresh == 2:
                return frame
        raise self._late("the grabber did not keep up", timeout_s)

    def _late(self, what: str, timeout_s: float) -> DeviceSilentError:
        return DeviceSilentError(
            what,
            part=self.name,
            limit=f"{timeout_s:g} s",
            todo="allow camera.collect_timeout_s at least 0.1 s a picture",
        )


@dataclass(frozen=True, slots=True)
class Crop:
    """The part of a grabber's frame that holds the picture: first row and column, and its size."""

    top: int
    left: int
    rows: int
    columns: int


class ResampledVideo:
    """A `VideoSource` that cuts the picture out of each frame and brings it to another size.

    A pixel of the result is the mean of what it covers where the picture shrinks, and between its
    neighbours where it grows. The corners of both meet: a place at row r of the frame comes to
    (r - top + 1/2) / scale - 1/2.

    Parameters
    ----------
    video
        The grabber.
    crop
        Which part of its frames.
    rows, columns
        Size of the recorder's pictures.
    """

    def __init__(self, video: VideoSource, crop: Crop, rows: int, columns: int) -> None:
        self._video, self._crop = video, crop
        self._size = rows, columns

    @property
    def scale(self) -> tuple[float, float]:
        """Rows and columns of the grabber's frame to one of the result."""
        return self._crop.rows / self._size[0], self._crop.columns / self._size[1]

    @property
    def name(self) -> str:
        """The grabber, what is cut out of its frames, and the scale."""
        crop, (down, across) = self._crop, self.scale
        return (
            f"{self._video.name}, rows {crop.top} to {crop.top + crop.rows} and columns "
            f"{crop.left} to {crop.left + crop.columns}, {down:.4g} rows and {across:.4g} columns "
            "to one"
        )

    def check(self) -> None:
        """See that the grabber is there."""
        self._video.check()

    def start(self) -> None:
        """Begin to stream."""
        self._video.start()

    def read(self, timeout_s: float) -> VideoFrame:
        """Return the next whole frame in the new size; raise as the grabber does."""
        frame = self._video.read(timeout_s)
        return replace(frame, pixels=self._resampled(frame.pixels))

    def stop(self) -> None:
        """Stop streaming."""
        self._video.stop()

    def close(self) -> None:
        """Release the grabber. Safe to call twice."""
        self._video.close()

    def _resampled(self, pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        crop, (rows, columns) = self._crop, self._size
        part = pixels[crop.top : crop.top + crop.rows, crop.left : crop.left + crop.columns]
        shrinks = crop.rows >= rows and crop.columns >= columns
        way = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        return np.asarray(cv2.resize(part, (columns, rows), interpolation=way), dtype=np.uint8)
