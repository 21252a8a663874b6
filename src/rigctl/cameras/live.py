"""A shot with a camera that streams into memory: the last frames are always there."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable

import numpy as np

from rigctl.cameras.capture import RecordingConfirmation
from rigctl.cameras.checks import Expected, check_frames
from rigctl.cameras.frames import FrameSequence
from rigctl.cameras.playback import VideoSource
from rigctl.cameras.v4l2 import VideoFrame
from rigctl.config import FreeRateCamera
from rigctl.errors import DeviceSilentError, FramesError, RecordingNotConfirmedError, RigError

_READ_S = 0.1
_RATE_FRAMES = 10
_RATE_TOLERANCE = 0.1
_LATEST_MARK_S = 0.25
"""A mark may come this long after the fire; frames are kept for it."""


class LiveCapture:
    """A `Capture` on a streaming camera.

    A thread of its own reads every frame while a recording runs. It keeps the last
    `frames_before_mark` and some for a late mark, and after the mark all those of the shot: the
    memory has a bound. The frames of a shot are numbers `mark` - `frames_before_mark` to `mark` +
    `frames_after_mark` - 1, where the mark is the first frame to arrive after the rig fired.

    Parameters
    ----------
    settings
        Rate, window about the mark and time limits.
    source
        The camera.
    clock
        Monotonic seconds.
    """

    def __init__(
        self,
        settings: FreeRateCamera,
        source: VideoSource,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._settings, self._source, self._clock = settings, source, clock
        self._changed = threading.Condition()
        self._kept: deque[VideoFrame] = deque()
        self._mark: int | None = None
        self._failure: RigError | None = None
        self._ending = threading.Event()
        self._reader: threading.Thread | None = None

    @property
    def name(self) -> str:
        """The camera."""
        return self._source.name

    def check(self) -> None:
        """Ask the camera for a sign of life."""
        if self._reader is None:
            self._source.check()

    def start(self) -> RecordingConfirmation:
        """Stream, and return once frames arrive at the configured rate, within 10 %.

        Raises
        ------
        RecordingNotConfirmedError
            They do not within `start_timeout_s`; streaming is stopped.
        DeviceError, FramesError
            The camera is not there, is busy or grants another format.
        """
        self.stop()
        self._kept.clear()
        self._mark, self._failure = None, None
        self._ending.clear()
        self._source.start()
        self._reader = threading.Thread(target=self._read_on, name="camera", daemon=True)
        self._reader.start()
        with self._changed:
            self._changed.wait_for(self._settled, self._settings.start_timeout_s)
            rate, failure, count = self._rate(), self._failure, len(self._kept)
        if failure is not None or rate is None or not self._is_configured(rate):
            self.stop()
            raise self._not_confirmed(rate, count) from failure
        return RecordingConfirmation(self.name, self._clock(), f"{count} frames at {rate:.1f} /s")

    def mark(self, late_s: float = 0.0) -> None:
        """Note that the rig fired `late_s` ago: the mark is the frame that was next then."""
        late = round(late_s * self._settings.picture_rate_hz)
        with self._changed:
            if self._kept:
                self._mark = self._kept[-1].number + 1 - late

    def collect(self) -> FrameSequence:
        """Wait for the frames after the mark, stop, and return those about it.

        Raises
        ------
        FramesError
            No mark was set, the frames did not come within `collect_timeout_s`, or they are not
            as they should be.
        DeviceError
            The camera failed while it recorded.
        """
        with self._changed:
            done = self._changed.wait_for(self._is_complete, self._settings.collect_timeout_s)
            mark, failure, kept = self._mark, self._failure, list(self._kept)
        self.stop()
        if failure is not None:
            raise failure
        if mark is None or not done:
            raise FramesError(
                "the frames after the mark did not come",
                part=self.name,
                value=f"frame {kept[-1].number}" if kept else "no frame",
                limit=f"{self._settings.collect_timeout_s:g} s",
                todo="check the camera's cable and frame rate",
            )
        before = self._settings.frames_before_mark
        count = before + self._settings.frames_after_mark
        expected = Expected(mark - before, count, self._settings.rows, self._settings.columns)
        frames = _sequence(kept, expected, self.name)
        check_frames(frames, expected)
        return frames

    def stop(self) -> None:
        """Stop streaming; harmless when nothing streams."""
        reader, self._reader = self._reader, None
        self._ending.set()
        if reader is not None:
            reader.join(timeout=10 * _READ_S)
        self._source.stop()

    def close(self) -> None:
        """Release the camera. Safe to call twice."""
        self.stop()
        self._source.close()

    def _read_on(self) -> None:
        while not self._ending.is_set():
            try:
                frame = self._source.read(_READ_S)
            except DeviceSilentError:
                continue
            except RigError as error:
                with self._changed:
                    self._failure = error
                    self._changed.notify_all()
                return
            with self._changed:
                self._keep(frame)
                self._changed.notify_all()

    def _keep(self, frame: VideoFrame) -> None:
        if self._mark is None:
            self._kept.append(frame)
            late = round(_LATEST_MARK_S * self._settings.picture_rate_hz)
            kept = max(self._settings.frames_before_mark, _RATE_FRAMES) + late
            while len(self._kept) > kept:
                self._kept.popleft()
        elif not self._is_complete():
            self._kept.append(frame)

    def _is_complete(self) -> bool:
        if self._failure is not None:
            return True
        if self._mark is None or not self._kept:
            return False
        return self._kept[-1].number >= self._mark + self._settings.frames_after_mark - 1

    def _settled(self) -> bool:
        if self._failure is not None:
            return True
        rate = self._rate()
        enough = len(self._kept) >= self._settings.frames_before_mark
        return enough and rate is not None and self._is_configured(rate)

    def _rate(self) -> float | None:
        if len(self._kept) < _RATE_FRAMES:
            return None
        first, last = self._kept[-_RATE_FRAMES], self._kept[-1]
        elapsed_s = last.time_s - first.time_s
        return (last.number - first.number) / elapsed_s if elapsed_s > 0 else None

    def _is_configured(self, rate: float) -> bool:
        wanted = self._settings.frame_rate_hz
        return abs(rate - wanted) <= _RATE_TOLERANCE * wanted

    def _not_confirmed(self, rate: float | None, count: int) -> RecordingNotConfirmedError:
        found = f"{count} frames" if rate is None else f"{rate:.1f} frames/s"
        return RecordingNotConfirmedError(
            "the camera does not deliver frames at its rate",
            part=self.name,
            value=found,
            limit=f"{self._settings.frame_rate_hz:g} frames/s within "
            f"{self._settings.start_timeout_s:g} s",
            todo="check the camera's cable, exposure time and frame rate",
        )


def _sequence(kept: list[VideoFrame], expected: Expected, source: str) -> FrameSequence:
    wanted = range(expected.first, expected.first + expected.count)
    chosen = [frame for frame in kept if frame.number in wanted]
    lost = sorted(number for frame in kept for number in frame.lost if number in wanted)
    if not chosen:
        raise FramesError(
            "every frame of the shot was lost",
            part=source,
            limit=f"{expected.count} frames",
            todo="check the computer's load and the camera's cable",
        )
    return FrameSequence(
        pixels=np.stack([frame.pixels for frame in chosen]),
        times_s=np.array([frame.time_s for frame in chosen], dtype=np.float64),
        sequence=np.array([frame.number for frame in chosen], dtype=np.int64),
        lost=tuple(lost),
        source=source,
    )
