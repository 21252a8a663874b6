"""Frames from files: multi-page TIFF, NPY, a folder of PNG, or a video file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import tifffile
from numpy.typing import NDArray

from analysis.errors import InputError

TIFF_SUFFIXES = (".tif", ".tiff")
VIDEO_SUFFIXES = (".avi", ".mkv", ".mp4")
SUFFIXES = (*TIFF_SUFFIXES, ".npy", *VIDEO_SUFFIXES)
GREY_TOLERANCE = 2
"""Codecs that store colour bring grey back to within this many levels between channels."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameStack:
    """Frames of one shot.

    Attributes
    ----------
    pixels
        8-bit grey levels, shape (frames, rows, columns).
    times_s
        Recorded time of each frame counted from the first, where a file beside the frames holds
        it, else None.
    """

    pixels: NDArray[np.uint8]
    times_s: NDArray[np.float64] | None


def read_stack(path: Path) -> FrameStack:
    """Read the frames of one shot.

    Recorded times are taken from a JSON file of the same name beside the frames
    (`times_s`, docs/reference/wire-protocols.md), if there is one.

    Raises
    ------
    InputError
        The file is absent, of another kind, damaged, or does not hold 8-bit grey frames; with the
        frame where one is at fault.
    """
    if not path.exists():
        raise InputError(path, "no such file or folder")
    if path.is_dir():
        pixels = _read_folder(path)
    elif path.suffix.lower() in TIFF_SUFFIXES:
        pixels = _read_tiff(path)
    elif path.suffix.lower() == ".npy":
        pixels = _read_npy(path)
    elif path.suffix.lower() in VIDEO_SUFFIXES:
        pixels = _read_video(path)
    else:
        raise InputError(path, f"frames are read from {', '.join(SUFFIXES)} or a folder of PNG")
    if pixels.ndim != 3 or pixels.dtype != np.uint8:
        raise InputError(
            path,
            f"holds {pixels.dtype} values of shape {pixels.shape}; 8-bit grey frames (frames, "
            "rows, columns) are needed",
        )
    return FrameStack(np.ascontiguousarray(pixels), _recorded_times(path, len(pixels)))


def _read_tiff(path: Path) -> NDArray[np.uint8]:
    pages = []
    try:
        with tifffile.TiffFile(path) as tiff:
            size = path.stat().st_size
            for index, page in enumerate(tiff.pages):
                end = max(
                    (o + n for o, n in zip(page.dataoffsets, page.databytecounts, strict=True)),
                    default=0,
                )
                if end > size:
                    raise InputError(
                        path,
                        f"truncated in frame {index}: its data end at byte {end}, the file at "
                        f"{size}",
                    )
                pages.append(page.asarray())
            if pages and not _ends_with_last_page(tiff):
                raise InputError(
                    path,
                    f"truncated after frame {len(pages) - 1}: the next frame lies beyond the "
                    f"file's end at byte {size}",
                )
    except InputError:
        raise
    # A damaged TIFF makes the library raise whatever its parser stumbles over.
    except Exception as error:
        raise InputError(path, f"damaged after {len(pages)} whole frames: {error}") from error
    return _stacked(path, pages)


def _ends_with_last_page(tiff: tifffile.TiffFile) -> bool:
    """Return whether the last page found says that no other follows.

    The library passes over a following page that lies beyond the end of the file.
    """
    tiff.filehandle.seek(tiff.pages.next_page_offset or 0)
    following = tiff.filehandle.read(tiff.tiff.offsetsize)
    return len(following) == tiff.tiff.offsetsize and not any(following)


def _read_npy(path: Path) -> NDArray[np.uint8]:
    try:
        return np.asarray(np.load(path, allow_pickle=False))
    except (ValueError, OSError, EOFError) as error:
        raise InputError(path, f"not a whole NPY file: {error}") from error


def _read_folder(path: Path) -> NDArray[np.uint8]:
    names = sorted(path.glob("*.png"))
    if not names:
        raise InputError(path, "a folder without PNG files")
    pages = []
    for name in names:
        page = cv2.imread(str(name), cv2.IMREAD_UNCHANGED)
        if page is None:
            raise InputError(name, "not a whole PNG file")
        pages.append(np.asarray(page))
    return _stacked(path, pages)


def _read_video(path: Path) -> NDArray[np.uint8]:
    video = cv2.VideoCapture(str(path))
    pages: list[NDArray[np.generic]] = []
    try:
        if not video.isOpened():
            raise InputError(path, "no decoder here opens this video")
        while True:
            whole, page = video.read()
            if not whole:
                break
            pages.append(_grey(path, len(pages), np.asarray(page)))
    finally:
        video.release()
    return _stacked(path, pages)


def _grey(path: Path, index: int, page: NDArray[np.generic]) -> NDArray[np.generic]:
    if page.ndim == 2:
        return page
    channels = page.astype(np.int16)
    spread = int(np.ptp(channels, axis=2).max())
    if spread > GREY_TOLERANCE:
        raise InputError(
            path, f"frame {index} is in colour: its channels differ by up to {spread} levels"
        )
    return page[:, :, 1]


def _stacked(path: Path, pages: Sequence[NDArray[np.generic]]) -> NDArray[np.uint8]:
    if not pages:
        raise InputError(path, "holds no frames")
    for index, page in enumerate(pages):
        if page.shape != pages[0].shape or page.dtype != pages[0].dtype:
            raise InputError(
                path,
                f"frame {index} is {page.dtype} of shape {page.shape}, the first is "
                f"{pages[0].dtype} of shape {pages[0].shape}",
            )
    return np.asarray(np.stack(pages))


def _recorded_times(path: Path, frames: int) -> NDArray[np.float64] | None:
    beside = path.with_suffix(".json")
    if path.is_dir() or not beside.exists():
        return None
    try:
        times = np.array(json.loads(beside.read_text())["times_s"], dtype=np.float64)
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(beside, f"does not hold times_s as a list of seconds: {error}") from error
    if times.shape != (frames,):
        raise InputError(beside, f"times_s has {times.size} times for {frames} frames")
    return np.asarray(times - times[0])
