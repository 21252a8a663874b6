"""Frames of a grabber brought to the size of the recorder's pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rigctl.cameras.playback import VideoSource
from rigctl.cameras.v4l2 import VideoFrame


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
