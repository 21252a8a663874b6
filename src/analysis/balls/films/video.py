"""Films in video files, with the time of each frame as the container has it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import cast

import cv2
import numpy as np

from analysis.balls.films.film import Film, FilmHead, Floats, Picture, Readout
from analysis.errors import InputError, counted
from analysis.files import FrameBudget
from analysis.imaging.files.video_file import open_video

MOST_FRAMES = 1_000_000
GREY_TOLERANCE = 2
"""Codecs that store colour bring grey back to within this many levels between channels."""
UNEVEN = 1e-3
"""Frames whose distances in time differ by more than this share have no single rate."""


class VideoFilm(Film):
    """A video that OpenCV's decoders open; its frames are read one after another.

    Raises
    ------
    InputError
        No decoder opens it, it ends before its container says, or it holds no frame.
    """

    def __init__(self, path: Path) -> None:
        video = open_video(path)
        try:
            rate = float(video.get(cv2.CAP_PROP_FPS))
            turned = round(float(video.get(cv2.CAP_PROP_ORIENTATION_META))) % 180 != 0
            stated = round(float(video.get(cv2.CAP_PROP_FRAME_COUNT)))
            _, first = video.read()
            if first is None:
                raise InputError(path, "holds no frame that can be read")
            FrameBudget(path).claim(first.shape)
            times = [float(video.get(cv2.CAP_PROP_POS_MSEC))]
            while len(times) < MOST_FRAMES and video.grab():
                times.append(float(video.get(cv2.CAP_PROP_POS_MSEC)))
        finally:
            video.release()
        notes = []
        if 0 < stated != len(times):
            have = f"{counted(len(times), 'frame')} can be read, the container counts {stated}"
            notes.append(f"{have}: the rest is missing or damaged")
        self._grey = bool(np.ptp(first.astype(np.int16), axis=2).max() <= GREY_TOLERANCE)
        readout: Readout = "columns" if turned else "rows"
        super().__init__(
            path,
            FilmHead(
                frames=len(times),
                height=first.shape[0],
                width=first.shape[1],
                channels=1 if self._grey else 3,
                times_s=_seconds(np.array(times), rate),
                rate_hz=rate if rate > 0 else None,
                encoded=True,
                compressed=True,
                readout=readout,
                notes=tuple(notes),
            ),
        )

    def _read(self) -> Iterator[Picture]:
        video = open_video(self.path)
        try:
            for _ in range(self.head.frames):
                whole, picture = video.read()
                if not whole:
                    return
                if self._grey:
                    picture = picture[:, :, 1:2]
                yield cast("Picture", np.ascontiguousarray(picture))
        finally:
            video.release()


def _seconds(milliseconds: Floats, rate: float) -> Floats | None:
    """Return recorded times in s; None where they do not increase.

    Containers round times, some to a millisecond: those of one rate are put on it.
    """
    times = 1e-3 * (milliseconds - milliseconds[0])
    if len(times) < 2 or not np.all(np.diff(times) > 0):
        return None
    count = np.arange(len(times))
    step = (times[-1] - times[0]) / (len(times) - 1)
    if np.abs(times - step * count).max() < 1.1e-3:
        even = 1.0 / rate if rate > 0 and abs(step * rate - 1.0) < UNEVEN else step
        return np.asarray(even * count)
    return np.asarray(times)
