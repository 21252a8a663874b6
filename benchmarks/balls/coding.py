"""Codecs of films: MPEG-4 by OpenCV, H.264 by PyAV (pip install av), as telephones write it."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Pictures = Sequence[NDArray[np.uint8]]


def write_mpeg4(path: Path, pictures: Pictures, rate_hz: float) -> None:
    """Write frames as OpenCV does by itself."""
    code = cv2.VideoWriter.fourcc(*"mp4v")
    video = cv2.VideoWriter(str(path), code, rate_hz, pictures[0].shape[1::-1])
    for picture in pictures:
        video.write(picture)
    video.release()


def write_h264(path: Path, pictures: Pictures, rate_hz: float, quality: int) -> None:
    """Write frames as H.264 with halved colours and frames predicted both ways.

    Parameters
    ----------
    quality
        Constant rate factor of x264: 18 can hardly be told from the original, 28 shows blocks.
    """
    # An optional library of the benchmark, without types.
    av: Any = importlib.import_module("av")
    container = av.open(str(path), "w")
    stream = container.add_stream("libx264", rate=Fraction(rate_hz).limit_denominator(1000))
    stream.height, stream.width = pictures[0].shape[:2]
    stream.pix_fmt = "yuv420p"
    stream.options = {"crf": str(quality), "preset": "fast"}
    for picture in pictures:
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="bgr24")
        container.mux(stream.encode(frame))
    container.mux(stream.encode())
    container.close()


def sharpened(picture: NDArray[np.uint8], amount: float) -> NDArray[np.uint8]:
    """Return a picture with steeper edges, as telephones make it."""
    values = picture.astype(np.float32)
    soft = np.asarray(cv2.GaussianBlur(values, (0, 0), 1.2))
    return np.clip(np.rint(values + amount * (values - soft)), 0, 255).astype(np.uint8)
