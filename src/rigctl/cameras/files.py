"""The capture folder as a source of pictures from the tape."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from uuid import uuid4

from rigctl.cameras.frames import FrameSequence
from rigctl.cameras.stack_file import read_stack
from rigctl.devices.ektapro import EktaproLink
from rigctl.errors import DeviceAbsentError, FramesError

_POLL_S = 0.01


class CaptureFolder:
    """A `PictureSource` that has the digitiser write into a folder and reads what appears.

    A stack counts as there once its JSON has its final name, which the digitiser gives it last.
    The files of a stack are removed when the next one is asked for; files of others stay.

    Parameters
    ----------
    folder
        The folder the digitiser writes to.
    recorder
        The recorder that is told to transfer.
    picture_rate_hz
        Pictures per second that the recorder is set to.
    clock, wait
        Monotonic seconds, and a wait in seconds.
    """

    def __init__(
        self,
        folder: Path,
        *,
        recorder: EktaproLink,
        picture_rate_hz: float,
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self._folder, self._recorder, self._rate = folder, recorder, picture_rate_hz
        self._clock, self._wait = clock, wait
        self._handed_over: Path | None = None

    @property
    def name(self) -> str:
        """The folder, as errors and manifests call it."""
        return f"capture folder {self._folder}"

    def check(self) -> None:
        """See that the folder is there and may be read.

        Raises
        ------
        DeviceAbsentError
            It is not.
        """
        if not (self._folder.is_dir() and os.access(self._folder, os.R_OK | os.X_OK)):
            raise DeviceAbsentError(
                "the folder is not there or may not be read",
                part=self.name,
                todo="mount or make it, or correct camera.source.folder",
            )

    def fetch(self, first: int, count: int, timeout_s: float) -> FrameSequence:
        """Have `count` pictures from number `first` digitised, and read them.

        Raises
        ------
        FramesError
            The stack did not appear in time, or is damaged or contradicts itself.
        DeviceError
            The recorder refused the transfer or gave no answer.
        """
        deadline = self._clock() + timeout_s
        self._remove_last()
        name = f"rig-{uuid4().hex}"
        self._recorder.transfer(first, count, name)
        note = self._folder / f"{name}.json"
        self._handed_over = note
        while not note.exists():
            if self._clock() >= deadline:
                raise FramesError(
                    "no frames came",
                    part=str(note.with_suffix(".tiff")),
                    limit=f"{timeout_s:g} s",
                    todo="check the digitiser and its disk space",
                )
            self._wait(_POLL_S)
        return read_stack(note, picture_rate_hz=self._rate)

    def close(self) -> None:
        """Do nothing: a folder holds no device."""

    def _remove_last(self) -> None:
        if self._handed_over is not None:
            self._handed_over.with_suffix(".tiff").unlink(missing_ok=True)
            self._handed_over.unlink(missing_ok=True)
            self._handed_over = None
