"""The camera: parameters, a ring of memory, and frames saved on its storage."""

from __future__ import annotations

import io
import threading
from collections.abc import Callable
from enum import StrEnum

import numpy as np
import tifffile
from numpy.typing import NDArray

MODEL = "CR14-1.0"
STORAGE = "sda1"
MEMORY_FRAMES = 4000
FASTEST_HZ, LEAST_ROWS, SENSOR_COLUMNS = 40_000.0, 16, 1280


class CameraFault(StrEnum):
    """What can go wrong, as `Laboratory.fault` names it."""

    SILENT = "silent"
    NO_JSON = "no-json"
    REFUSES = "refuses"
    NEVER_RECORDS = "never-records"
    OTHER_SIZE = "other-size"
    LOST_FILE = "lost-file"
    DAMAGED_FILE = "damaged-file"
    NEVER_SAVES = "never-saves"


class Camera:
    """Idle, recording or saving; whatever it would have done is worked out from the clock.

    Parameters
    ----------
    clock
        Laboratory time in seconds.
    picture
        The frame (rows, 240), 8 bits, of a laboratory time.
    """

    def __init__(
        self,
        clock: Callable[[], float],
        picture: Callable[[float, int | None], NDArray[np.uint8]],
    ) -> None:
        self._clock, self._picture = clock, picture
        self._lock = threading.RLock()
        self._size, self._rate_hz = (1280, 1024), 1057.0
        self._began_s: float | None = None
        self._frames, self._last_s = 0, 0.0
        self._saving = False
        self._files: dict[str, dict[str, bytes]] = {}
        self.fault: CameraFault | None = None

    def parameters(self) -> dict[str, object]:
        """Return every parameter that it has."""
        with self._lock:
            columns, rows = self._size
            return {
                "cameraApiVersion": "0.9",
                "cameraModel": MODEL,
                "cameraSerial": "00000",
                "state": "recording" if self._began_s is not None else "idle",
                "videoState": "filesave" if self._saving else "live",
                "resolution": {"hRes": columns, "vRes": rows, "hOffset": 0, "vOffset": 0},
                "frameRate": self._rate_hz,
                "framePeriod": round(1e9 / self._rate_hz),
                "cameraMaxFrames": MEMORY_FRAMES,
                "playbackLength": self._frames,
                "playbackPosition": 0,
            }

    def set(self, wanted: dict[str, object]) -> dict[str, object]:
        """Set parameters; a size or rate that it has not is refused."""
        with self._lock:
            if self._began_s is not None:
                return {"error": "not while recording"}
            size = wanted.get("resolution")
            if isinstance(size, dict):
                columns, rows = int(size.get("hRes", 0)), int(size.get("vRes", 0))
                if not (16 <= columns <= SENSOR_COLUMNS and columns % 16 == 0):
                    return {"error": "Invalid Resolution"}
                if rows < LEAST_ROWS or rows % 2:
                    return {"error": "Invalid Resolution"}
                grown = 2 if self.fault is CameraFault.OTHER_SIZE else 1
                self._size = (columns * grown, rows)
            rate = wanted.get("frameRate")
            if isinstance(rate, (int, float)):
                if not 1.0 <= rate <= FASTEST_HZ:
                    return {"error": "Invalid frame rate"}
                self._rate_hz = float(rate)
            return self.parameters()

    def start_recording(self) -> dict[str, object]:
        """Record into the ring."""
        with self._lock:
            if self.fault is not CameraFault.NEVER_RECORDS:
                self._began_s = self._clock()
            return {"state": self.parameters()["state"]}

    def stop_recording(self) -> dict[str, object]:
        """Stop; what lies in the ring stays."""
        with self._lock:
            if self._began_s is None:
                return {"error": "not recording"}
            taken = int((self._clock() - self._began_s) * self._rate_hz) + 1
            self._last_s = self._began_s + (taken - 1) / self._rate_hz
            self._frames, self._began_s = min(taken, MEMORY_FRAMES), None
            return {"state": "idle"}

    def flush(self) -> dict[str, object]:
        """Empty the ring."""
        with self._lock:
            self._frames = 0
            return {"state": self.parameters()["state"]}

    def save(self, order: dict[str, object]) -> dict[str, object]:
        """Save frames as TIFF files of three colours, in a folder of its storage."""
        with self._lock:
            first, count = int(str(order.get("start", 0))), int(str(order.get("length", 0)))
            if order.get("format") != "tiff" or order.get("device") != STORAGE:
                return {"error": "no such format or device"}
            if not 0 < count <= self._frames - first:
                return {"error": "no such frames"}
            instants = [
                self._last_s - (self._frames - 1 - number) / self._rate_hz
                for number in range(first, first + count)
            ]
            self._saving = True
            work = (str(order.get("filename")), instants, self._size[1])
            threading.Thread(target=self._save, args=work, name="storage", daemon=True).start()
            return {"state": "saving"}

    def _save(self, folder: str, instants: list[float], rows: int) -> None:
        files: dict[str, bytes] = {}
        for number, instant in enumerate(instants, 1):
            files[f"frame_{number:06d}.tiff"] = self._file(instant, rows)
        if self.fault is CameraFault.LOST_FILE:
            files.popitem()
        if self.fault is CameraFault.DAMAGED_FILE:
            name, data = files.popitem()
            files[name] = data[: len(data) // 2]
        with self._lock:
            if self.fault is not CameraFault.NEVER_SAVES:
                self._files[folder] = files
                self._saving = False

    def listed(self) -> dict[str, object]:
        """Return folders and files of the storage, as the camera's web page gets them."""
        with self._lock:
            listed: dict[str, object] = {"totalFileCount": len(self._files)}
            for number, (folder, files) in enumerate(self._files.items()):
                names: dict[str, object] = {f"file{n}": name for n, name in enumerate(files)}
                about = {"folderName": folder, "totalFileCount": len(files)}
                listed[f"folder{number}"] = names | about
            return listed

    def file(self, path: str) -> bytes | None:
        """Return a saved file; None where there is none."""
        folder, _, name = path.partition("/")
        with self._lock:
            return self._files.get(folder, {}).get(name)

    def _file(self, instant: float, rows: int) -> bytes:
        grey = self._picture(instant, rows)
        held = io.BytesIO()
        tifffile.imwrite(held, np.repeat(grey[:, :, None], 3, axis=2), photometric="rgb")
        return held.getvalue()
