"""Chronos cameras of Krontech over HTTP: control, trigger, save, fetch.

The interface is that of the camera's own web page: parameters under `/control/p`, orders under
`/control`, files of its storage under `/cgi-bin`. Sources: Krontech's repositories pychronos
(parameters and methods), chronos-http (files) and chronos-examples.
"""

from __future__ import annotations

import io
import time
import uuid
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import cv2
import httpx
import numpy as np
import tifffile
from numpy.typing import NDArray

from rigctl.cameras.frames import FrameSequence
from rigctl.cameras.memory import Recorded
from rigctl.config import ChronosCamera
from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceSilentError,
    FramesError,
)

Json: TypeAlias = Any
"""What a parameter may be: its type is not known before it is looked at."""

_POLL_S = 0.05
_SETTLED_S = 1.0
_LONGEST_ANSWER = 1 << 20
_RATE_TOLERANCE = 0.01
_BYTES_A_PIXEL = 8
"""Most that a file may have: three colours of 16 bits and some of a head."""


class Chronos:
    """A `MemoryCamera`: the camera records into a ring of its memory.

    Parameters
    ----------
    settings
        Address, size, rate and storage.
    url
        The address, resolved.
    clock, wait
        Monotonic seconds, and a wait in seconds.
    """

    def __init__(
        self,
        settings: ChronosCamera,
        url: str,
        *,
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self._settings, self._clock, self._wait = settings, clock, wait
        self._http = httpx.Client(base_url=url, timeout=settings.answer_timeout_s, trust_env=False)
        self._url = url

    @property
    def name(self) -> str:
        """Kind and address."""
        return f"camera (chronos at {self._url})"

    def check(self) -> None:
        """Ask for model and state.

        Raises
        ------
        DeviceError
            Nobody answers, or it is no Chronos.
        """
        model, _ = self._parameter("cameraModel"), self._parameter("state")
        if not isinstance(model, str) or not model:
            raise self._strange("cameraModel", model, "a model")

    def start(self) -> None:
        """Set size and rate, see that the camera took them, empty its memory, record.

        Raises
        ------
        DeviceError
            It refused, gave no answer, or has another size or rate.
        """
        wanted = {"hRes": self._settings.columns, "vRes": self._settings.rows}
        self._order("p", {"resolution": wanted, "frameRate": self._settings.frame_rate_hz})
        size = self._parameter("resolution")
        granted = {name: size.get(name) for name in wanted} if isinstance(size, dict) else size
        if granted != wanted:
            raise self._strange("size", granted, str(wanted))
        rate = self._parameter("frameRate")
        bound = _RATE_TOLERANCE * self._settings.frame_rate_hz
        if not isinstance(rate, (int, float)) or abs(rate - self._settings.frame_rate_hz) > bound:
            raise self._strange("rate", rate, f"{self._settings.frame_rate_hz:g} frames/s")
        self._order("flushRecording")
        self._order("startRecording")

    def is_recording(self) -> bool:
        """Say whether it records."""
        return bool(self._parameter("state") == "recording")

    def end(self) -> Recorded:
        """Stop recording; the last frame is taken to be halfway through that order's round trip."""
        sent = self._clock()
        self._order("stopRecording")
        answered = self._clock()
        frames = self._parameter("playbackLength")
        if not isinstance(frames, int) or frames < 0:
            raise self._strange("playbackLength", frames, "a number of frames")
        return Recorded(frames, (sent + answered) / 2)

    def fetch(self, first: int, count: int, timeout_s: float) -> FrameSequence:
        """Have frames saved as TIFF on the camera's storage, and fetch each.

        Raises
        ------
        FramesError
            They were not saved in time, or are not there, or not readable.
        DeviceError
            The camera refused or gave no answer.
        """
        deadline = self._clock() + timeout_s
        folder = f"rig-{uuid.uuid4().hex[:12]}"
        save = {"format": "tiff", "device": self._settings.storage, "filename": folder}
        self._order("startFilesave", {**save, "start": first, "length": count})
        while self._parameter("videoState") == "filesave":
            if self._clock() >= deadline:
                raise FramesError(
                    "the camera did not save the frames in time",
                    part=self.name,
                    limit=f"{timeout_s:g} s",
                    todo="use a faster storage, or allow camera.collect_timeout_s more",
                )
            self._wait(_POLL_S)
        names = self._saved(folder)
        settled_at = self._clock() + _SETTLED_S
        # It may take a moment before it says that it saves, and after it to show all files.
        while len(names) < count and self._clock() < min(settled_at, deadline):
            self._wait(_POLL_S)
            names = self._saved(folder)
        if len(names) != count:
            raise FramesError(
                "the camera saved another number of frames",
                part=self.name,
                value=f"{len(names)} files",
                limit=f"{count} files",
                todo="check the storage's free space",
            )
        pixels = [self._picture(f"{folder}/{name}") for name in names]
        sequence = np.arange(first, first + count, dtype=np.int64)
        times_s = sequence / self._settings.frame_rate_hz
        return FrameSequence(np.stack(pixels), times_s, sequence, (), self.name)

    def stop(self) -> None:
        """Stop recording where it records; raise a `DeviceError` if it gives no answer."""
        if self.is_recording():
            self._order("stopRecording")

    def close(self) -> None:
        """Release the connection. Safe to call twice."""
        self._http.close()

    def _saved(self, folder: str) -> list[str]:
        listed = self._json(self._ask("GET", f"/cgi-bin/listFiles?{self._settings.storage}"))
        for entry in listed.values():
            if isinstance(entry, dict) and entry.get("folderName") == folder:
                names = (str(entry[key]) for key in entry if key.startswith("file"))
                return sorted(names)
        return []

    def _picture(self, path: str) -> NDArray[np.uint8]:
        place = {"location": self._settings.storage, "fileName": path}
        most = 65_536 + self._settings.rows * self._settings.columns * _BYTES_A_PIXEL
        data = self._ask("GET", "/cgi-bin/pleaseGiveMeAFile", params=place, most=most)
        try:
            pixels = tifffile.imread(io.BytesIO(data))
        except (ValueError, OSError, KeyError, IndexError, tifffile.TiffFileError) as error:
            raise FramesError(
                f"a saved frame is damaged: {error}", part=f"{self.name}, {path}", todo="fire again"
            ) from error
        if pixels.dtype != np.uint8 or pixels.ndim not in {2, 3}:
            raise FramesError(
                "a saved frame has another depth",
                part=f"{self.name}, {path}",
                value=f"{pixels.shape} of {pixels.dtype}",
                limit="8 bits, grey or three colours",
            )
        grey = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
        wanted = (self._settings.rows, self._settings.columns)
        if grey.shape != wanted:
            raise FramesError(
                "a saved frame has another size",
                part=f"{self.name}, {path}",
                value=f"{grey.shape}",
                limit=f"{wanted} (rows, columns)",
                todo="compare the camera's format with rows and columns in the configuration",
            )
        return np.asarray(grey, dtype=np.uint8)

    def _parameter(self, name: str) -> Json:
        found = self._json(self._ask("GET", f"/control/p/{name}"))
        if name not in found:
            raise self._strange(name, found, f"the parameter {name}")
        return found[name]

    def _order(self, method: str, arguments: Mapping[str, Any] | None = None) -> None:
        answer = self._json(self._ask("POST", f"/control/{method}", body=dict(arguments or {})))
        if "error" in answer:
            raise self._strange(method, answer["error"], "no error")

    def _ask(
        self,
        method: str,
        path: str,
        *,
        body: Mapping[str, Any] | None = None,
        params: Mapping[str, str] | None = None,
        most: int = _LONGEST_ANSWER,
    ) -> bytes:
        try:
            with self._http.stream(method, path, json=body, params=params) as answer:
                data = b""
                for piece in answer.iter_bytes():
                    data += piece
                    if len(data) > most:
                        raise self._strange(path, f"more than {most} bytes", f"{most} bytes")
                if not answer.is_success:
                    raise self._strange(path, f"HTTP {answer.status_code}", "HTTP 200")
                return data
        except httpx.ConnectError as error:
            raise DeviceAbsentError(
                "nobody answers at this address",
                part=self.name,
                todo="check the camera's power, cable and camera.url",
            ) from error
        except httpx.TimeoutException as error:
            raise DeviceSilentError(
                f"no answer to {method} {path}",
                part=self.name,
                limit=f"{self._settings.answer_timeout_s:g} s",
                todo="check the camera and its network",
            ) from error
        except httpx.TransportError as error:
            raise DeviceAbsentError(
                f"the connection was lost: {type(error).__name__}",
                part=self.name,
                todo="check the camera's cable",
            ) from error

    def _json(self, data: bytes) -> dict[str, Any]:
        try:
            return dict(httpx.Response(200, content=data).json())
        except (ValueError, TypeError) as error:
            text = data[:40].decode("utf-8", errors="replace")
            raise self._strange("the answer", text, "JSON of a Chronos") from error

    def _strange(self, what: str, found: object, wanted: str) -> DeviceAnswerError:
        return DeviceAnswerError(
            f"{what} is not what it must be",
            part=self.name,
            value=str(found)[:100],
            limit=wanted,
            todo="check that this address is a Chronos, and its firmware and settings",
        )
