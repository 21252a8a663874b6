"""A shot with a camera that records into its own memory: frames are fetched afterwards."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from rigctl.cameras.capture import RecordingConfirmation
from rigctl.cameras.checks import Expected, check_frames
from rigctl.cameras.frames import FrameSequence
from rigctl.config import FreeRateCamera
from rigctl.errors import FramesError, RecordingNotConfirmedError

_POLL_S = 0.01
_AFTER_S = 0.05
"""Recorded beyond the last frame of a shot, for the way of the order to stop, s."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """What lies in a camera's memory once it has stopped.

    Attributes
    ----------
    frames
        How many; the first has the number 0.
    last_at
        Monotonic time at which the last one was taken, s.
    """

    frames: int
    last_at: float


@runtime_checkable
class MemoryCamera(Protocol):
    """A camera that records into a ring of its own memory until it is told to stop."""

    @property
    def name(self) -> str:
        """The camera, as errors and manifests call it."""

    def check(self) -> None:
        """Raise a `RigError` when the camera is not there."""

    def start(self) -> None:
        """Set size and rate, empty the memory, begin to record; return at once."""

    def is_recording(self) -> bool:
        """Say whether it records."""

    def end(self) -> Recorded:
        """Stop recording; return what the memory holds."""

    def fetch(self, first: int, count: int, timeout_s: float) -> FrameSequence:
        """Bring `count` frames from number `first`, or raise within the time."""

    def stop(self) -> None:
        """Stop whatever it does; harmless at rest."""

    def close(self) -> None:
        """Release the camera. Safe to call twice."""


class MemoryCapture:
    """A `Capture` on such a camera.

    The frame of the mark is counted back from the last frame: when that was taken, the camera
    says. Half the round trip of the order to stop is what the mark may be wrong by.

    Parameters
    ----------
    settings
        Rate, window about the mark and time limits.
    camera
        The camera.
    clock, wait
        Monotonic seconds, and a wait in seconds.
    """

    def __init__(
        self,
        settings: FreeRateCamera,
        camera: MemoryCamera,
        *,
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self._settings, self._camera = settings, camera
        self._clock, self._wait = clock, wait
        self._fired_at: float | None = None

    @property
    def name(self) -> str:
        """The camera."""
        return self._camera.name

    def check(self) -> None:
        """Ask the camera for a sign of life."""
        self._camera.check()

    def start(self) -> RecordingConfirmation:
        """Record, and return once the camera says so and the frames before the mark are taken.

        Raises
        ------
        RecordingNotConfirmedError
            It does not say so within `start_timeout_s`.
        DeviceError
            The camera refused or gave no answer; it is stopped.
        """
        self._fired_at = None
        began = self._clock()
        try:
            self._camera.start()
            before_s = self._settings.frames_before_mark / self._settings.picture_rate_hz
            while not self._camera.is_recording():
                if self._clock() - began >= self._settings.start_timeout_s:
                    raise self._not_confirmed()
                self._wait(_POLL_S)
            self._wait(before_s + _AFTER_S)
        except Exception:
            self._camera.stop()
            raise
        return RecordingConfirmation(self.name, self._clock(), "the camera says that it records")

    def mark(self, late_s: float = 0.0) -> None:
        """Note that the rig fired `late_s` ago."""
        self._fired_at = self._clock() - late_s

    def collect(self) -> FrameSequence:
        """Wait for the frames after the mark, stop, and bring those about it.

        Raises
        ------
        FramesError
            There is no mark, the memory does not reach that far, or the frames are not those
            that were asked for.
        DeviceError
            The camera refused or gave no answer.
        """
        fired_at = self._fired_at
        if fired_at is None:
            raise FramesError("the recording carries no mark of the fire", part=self.name)
        deadline = self._clock() + self._settings.collect_timeout_s
        rate = self._settings.picture_rate_hz
        end_at = fired_at + self._settings.frames_after_mark / rate + _AFTER_S
        self._wait(max(0.0, end_at - self._clock()))
        recorded = self._camera.end()
        mark = recorded.frames - 1 - round((recorded.last_at - fired_at) * rate)
        count = self._settings.frames_before_mark + self._settings.frames_after_mark
        first = mark - self._settings.frames_before_mark
        if first < 0 or first + count > recorded.frames:
            raise FramesError(
                "the camera's memory does not hold the whole shot",
                part=self.name,
                value=f"{recorded.frames} frames, the fire at frame {mark}",
                limit=f"frames {first} to {first + count - 1}",
                todo="check memory, rate and frames_before_mark",
            )
        expected = Expected(first, count, self._settings.rows, self._settings.columns)
        frames = self._camera.fetch(first, count, max(0.0, deadline - self._clock()))
        check_frames(frames, expected)
        return frames

    def stop(self) -> None:
        """Stop recording; harmless when nothing records."""
        self._camera.stop()

    def close(self) -> None:
        """Release the camera. Safe to call twice."""
        self._camera.close()

    def _not_confirmed(self) -> RecordingNotConfirmedError:
        return RecordingNotConfirmedError(
            "the camera does not record",
            part=self.name,
            limit=f"within {self._settings.start_timeout_s:g} s",
            todo="look at the camera's own page",
        )
