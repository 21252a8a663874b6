"""Any film: which reader a file or a folder needs; video files with the times of their frames."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import cast

import cv2
import numpy as np
from cv2.typing import MatLike

from analysis.arrays import Floats
from analysis.balls.films.film import HELD_BYTES, Film, FilmHead, Picture, Readout, spread_frames
from analysis.balls.films.high_speed import FRAMES_SUFFIX, HEADER_SUFFIXES, CineFilm, PhotronFilm
from analysis.balls.films.raw import EXAMPLE, RAW_FILM_SUFFIX, RawFilm, RawLayout
from analysis.balls.films.stacks import TIFF_SUFFIXES, PictureFolder, PictureStack, read_npy_frames
from analysis.errors import InputError, counted
from analysis.files import FrameBudget
from analysis.imaging.files.png_files import SUFFIX as PNG_SUFFIX
from analysis.imaging.files.png_files import refuse_single
from analysis.imaging.files.tiff_file import read_tiff
from analysis.imaging.files.video_file import counts_frames, open_video

MOST_FRAMES = 1_000_000
GREY_TOLERANCE = 2
"""Codecs that store colour bring grey back to within this many levels between channels."""
UNEVEN = 1e-3
"""Frames whose distances in time differ by more than this share have no single rate."""
SQUARE = 2e-3
"""Pixels whose sides differ by less than this share are square: one in five hundred columns."""


class VideoFilm(Film):
    """A video that OpenCV's decoders open; its frames are read one after another.

    Where the file states that its pixels are wider or narrower than high, its pictures are
    stretched to square ones: a ball would be an ellipse.

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
            across, down = video.get(cv2.CAP_PROP_SAR_NUM), video.get(cv2.CAP_PROP_SAR_DEN)
            _, first = video.read()
            if first is None:
                raise InputError(path, "holds no frame that can be read")
            height, stored = first.shape[:2]
            self._size = stored, height
            if across > 0 and down > 0 and abs(across / down - 1.0) > SQUARE:
                wide = down / across if turned else across / down
                self._size = max(1, round(stored * wide)), height
            FrameBudget(path).claim((height, self._size[0], first.shape[2]))
            blue, green, red = cv2.split(first)
            pairs = ((blue, green), (green, red), (red, blue))
            self._grey = all(cv2.absdiff(*pair).max() <= GREY_TOLERANCE for pair in pairs)
            times = [float(video.get(cv2.CAP_PROP_POS_MSEC))]
            known = {0: self._plain(first)}
            every = stated * known[0].nbytes <= HELD_BYTES
            wanted = set(spread_frames(max(stated, 1), known[0].nbytes))
            while len(times) < MOST_FRAMES and video.grab():
                if len(times) in wanted or (every and len(times) < stated):
                    known[len(times)] = self._plain(video.retrieve()[1])
                times.append(float(video.get(cv2.CAP_PROP_POS_MSEC)))
        finally:
            video.release()
        notes = []
        if counts_frames(path) and 0 < stated != len(times):
            have = f"{counted(len(times), 'frame')} can be read, the container counts {stated}"
            notes.append(f"{have}: the rest is missing or damaged")
        width = self._size[0]
        if width != stored:
            sides = f"{across:g} wide to {down:g} high"
            stretched = f"pictures of {stored} columns are stretched to {width}"
            notes.append(f"the file states pixels that are {sides}: {stretched}")
        readout: Readout = "columns" if turned else "rows"
        super().__init__(
            path,
            FilmHead(
                frames=len(times),
                height=height,
                width=width,
                channels=1 if self._grey else 3,
                times_s=_seconds(np.array(times), rate),
                rate_hz=rate if rate > 0 else None,
                encoded=True,
                compressed=True,
                readout=readout,
                notes=tuple(notes),
            ),
        )
        self._read_before = known
        if len(known) == len(times):
            self._held = [known[k] for k in range(len(times))]

    def _plain(self, picture: MatLike) -> Picture:
        """Return a picture of square pixels, and of one channel where the film has no colours."""
        if self._size != picture.shape[1::-1]:
            picture = cv2.resize(picture, self._size, interpolation=cv2.INTER_LINEAR)
        own = picture[:, :, 1:2] if self._grey else picture
        return cast("Picture", np.ascontiguousarray(own))

    def _read(self) -> Iterator[Picture]:
        video = open_video(self.path)
        try:
            for _ in range(self.head.frames):
                whole, picture = video.read()
                if not whole:
                    return
                yield self._plain(picture)
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


VIDEO_SUFFIXES = (
    *(".avi", ".mkv", ".mp4", ".mov", ".m4v", ".webm"),
    *(".3gp", ".mts", ".m2ts", ".mpg", ".mpeg", ".wmv", ".gif"),
)
CINE_SUFFIX = ".cine"
PHOTRON_SUFFIXES = (FRAMES_SUFFIX, *HEADER_SUFFIXES)
READ_SUFFIXES = (*TIFF_SUFFIXES, ".npy", PNG_SUFFIX, *VIDEO_SUFFIXES, CINE_SUFFIX)
"""Of files that hold all of a film: an empty one is none."""
FILM_SUFFIXES = (*TIFF_SUFFIXES, ".npy", *VIDEO_SUFFIXES, CINE_SUFFIX, *PHOTRON_SUFFIXES)


def open_film(path: Path, raw: RawLayout | None = None) -> Film:
    """Open a film by what its name says that it is; `raw` are pictures of one without a header.

    Raises
    ------
    InputError
        Nothing is there, it is of another kind, or it cannot be read.
    """
    if not path.exists():
        raise InputError(path, "no such file or folder")
    suffix = path.suffix.lower()
    if path.is_file() and path.stat().st_size == 0 and suffix in READ_SUFFIXES:
        raise InputError(path, "is an empty file")
    try:
        if path.is_dir():
            return PictureFolder(path)
        if suffix in (*TIFF_SUFFIXES, ".npy"):
            return PictureStack(path, read_npy_frames if suffix == ".npy" else read_tiff)
        if suffix in VIDEO_SUFFIXES:
            return VideoFilm(path)
        if suffix == CINE_SUFFIX:
            return CineFilm(path)
        if suffix in PHOTRON_SUFFIXES:
            return PhotronFilm(path)
        if suffix == RAW_FILM_SUFFIX and raw is not None:
            return RawFilm(path, raw)
        if suffix == PNG_SUFFIX:
            refuse_single(path)
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror or error}") from error
    if suffix == RAW_FILM_SUFFIX:
        raise InputError(path, f"has no header; state its pictures with --raw {EXAMPLE}")
    kinds = ", ".join(FILM_SUFFIXES)
    raise InputError(path, f"films are read from {kinds}, or a folder of PNG or TIFF pictures")


def film_of_shot(folder: Path, shot: int) -> Path:
    """Return where the film of a shot lies in a campaign's `frames`; a folder where none does."""
    stem = folder / f"{shot:04d}"
    named = [stem.with_suffix(suffix) for suffix in FILM_SUFFIXES]
    return next((path for path in named if path.exists()), stem)
