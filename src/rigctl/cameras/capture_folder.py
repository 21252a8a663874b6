"""The capture folder as a source of pictures: each stack is a multi-page TIFF and its JSON."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError

from analysis.errors import InputError
from analysis.files import FrameBudget, read_bytes
from analysis.imaging.files.tiff_file import read_tiff
from rigctl.cameras.frames import FrameSequence
from rigctl.config.model import StrictModel
from rigctl.devices.ektapro import EktaproLink
from rigctl.errors import DeviceAbsentError, FramesError

_Number = Annotated[int, Field(ge=0, le=10**15)]


class StackNote(StrictModel):
    """What the JSON beside a stack says (wire-protocol reference, capture folder)."""

    frames: _Number
    rows: _Number
    columns: _Number
    frame_rate_hz: float = Field(gt=0, description="pictures per second")
    sequence: tuple[_Number, ...]
    times_s: tuple[float, ...]
    lost: tuple[_Number, ...]


def read_stack(note_path: Path, *, picture_rate_hz: float) -> FrameSequence:
    """Read one stack whose JSON is in place.

    Parameters
    ----------
    note_path
        The JSON; the TIFF has the same name with the ending ``.tiff``.
    picture_rate_hz
        Pictures per second that were configured.

    Returns
    -------
    FrameSequence
        Times from the first picture of the session, as the JSON states them.

    Raises
    ------
    FramesError
        A file is absent, damaged or truncated, or the JSON contradicts itself, the TIFF or the
        configured rate.
    """
    tiff_path = note_path.with_suffix(".tiff")
    note = _read_note(note_path)
    pixels = _read_pages(tiff_path, note)
    _check_rate(note, note_path, picture_rate_hz)
    return FrameSequence(
        pixels=pixels,
        times_s=np.array(note.times_s, dtype=np.float64),
        sequence=np.array(note.sequence, dtype=np.int64),
        lost=note.lost,
        source=str(tiff_path),
    )


def _read_note(path: Path) -> StackNote:
    try:
        note = StackNote.model_validate_json(read_bytes(path, "document_mb"))
    except InputError as error:
        raise FramesError(
            "the description of the stack cannot be read",
            part=str(path),
            value=error.reason,
            todo="check the capture folder",
        ) from error
    except ValidationError as error:
        first = error.errors()[0]
        raise FramesError(
            "the description of the stack is not as agreed",
            part=str(path),
            value=f"{'.'.join(map(str, first['loc'])) or 'the file'}: {first['msg']}",
            todo="check the digitiser against the wire-protocol reference",
        ) from error
    counts = {"sequence": len(note.sequence), "times_s": len(note.times_s)}
    for field, count in counts.items():
        if count != note.frames:
            raise _contradiction(path, f"{count} entries in {field}", f"frames = {note.frames}")
    return note


def _read_pages(path: Path, note: StackNote) -> NDArray[np.uint8]:
    size = (note.rows, note.columns)
    if not path.is_file():
        raise FramesError(
            "the stack cannot be read",
            part=str(path),
            value="no such file",
            todo="check the capture folder",
        )
    try:
        pages = read_tiff(path, FrameBudget(path))
    except InputError as error:
        raise FramesError(
            "the stack is damaged, truncated or too large",
            part=str(path),
            value=error.reason,
            limit=f"{note.frames} pages of {size} uint8",
            todo="check the disk space of the digitiser and transfer again",
        ) from error
    if len(pages) != note.frames:
        raise _contradiction(path, f"{len(pages)} pages", f"{note.frames} frames")
    for place, page in enumerate(pages):
        if page.dtype != np.uint8 or page.shape != size:
            raise _contradiction(
                path, f"page {place} of {page.shape} {page.dtype}", f"{size} uint8 (rows, columns)"
            )
    return np.stack(pages).astype(np.uint8, copy=False)


def _check_rate(note: StackNote, path: Path, picture_rate_hz: float) -> None:
    if note.frame_rate_hz != picture_rate_hz:
        raise _contradiction(
            path, f"{note.frame_rate_hz:g} pictures/s", f"{picture_rate_hz:g} pictures/s"
        )
    # Times beyond all bounds give what is no number, and is refused like any other.
    with np.errstate(over="ignore", invalid="ignore"):
        pictures = np.diff(np.array(note.times_s)) * picture_rate_hz
        off = np.abs(pictures - np.diff(np.array(note.sequence)))
    wrong = np.flatnonzero(~(off <= 0.25))
    if wrong.size:
        place = int(wrong[0]) + 1
        raise _contradiction(
            path,
            f"frame {place} {pictures[place - 1] / picture_rate_hz:.6f} s after the one before",
            f"{note.sequence[place] - note.sequence[place - 1]} pictures apart",
        )


def _contradiction(path: Path, found: str, expected: str) -> FramesError:
    return FramesError(
        "the stack is not what it should be",
        part=str(path),
        value=found,
        limit=expected,
        todo="check the recorder's format and the digitiser",
    )


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
        The recorder that transfers its pictures to the digitiser.
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
