"""What the frames of one shot may take while they are unpacked."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path

from analysis.errors import InputError
from analysis.files.limits import file_limits


class FrameBudget:
    """Counts frames, bytes and processor time of one shot, and refuses what is beyond the limits.

    Parameters
    ----------
    path
        File or folder of the frames, named in refusals.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._limits = path, file_limits()
        self._began = time.thread_time()
        self._frames, self._bytes = 0, 0

    @property
    def most_bytes(self) -> float:
        """Bytes that all frames together may unpack to."""
        return 1e6 * self._limits.frames_mb

    def claim(self, shape: Sequence[int], value_bytes: int = 1) -> None:
        """Count one frame before it is unpacked.

        Raises
        ------
        InputError
            Too many pixels, frames or bytes, or too much time has gone by.
        """
        frame, pixels = self._frames, math.prod(shape)
        if pixels > self._limits.frame_pixels:
            size = " x ".join(map(str, shape))
            raise self._beyond(
                f"frame {frame} has {size} pixels", f"{self._limits.frame_pixels}", "frame_pixels"
            )
        self._frames, self._bytes = frame + 1, self._bytes + pixels * value_bytes
        self.require_frames(self._frames)
        if self._bytes > self.most_bytes:
            raise self._beyond(
                f"its frames unpack to {self._bytes / 1e6:.6g} MB and more by frame {frame}",
                f"{self._limits.frames_mb:g} MB",
                "frames_mb",
            )
        self.require_time()

    def require_frames(self, frames: int) -> None:
        """Refuse more frames than a shot may have."""
        if frames > self._limits.frames:
            raise self._beyond(
                f"it holds {frames} frames or more", f"{self._limits.frames}", "frames"
            )

    def require_time(self) -> None:
        """Refuse when this thread has computed for too long."""
        spent = time.thread_time() - self._began
        if spent > self._limits.decode_s:
            raise self._beyond(
                f"unpacking took {spent:.1f} s by frame {self._frames}",
                f"{self._limits.decode_s:g} s",
                "decode_s",
            )

    def _beyond(self, found: str, limit: str, name: str) -> InputError:
        return InputError(
            self._path,
            f"{found}, allowed are {limit}; split or shrink it, or raise files.{name} in the "
            "configuration",
        )
