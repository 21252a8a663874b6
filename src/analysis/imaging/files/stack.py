"""Frames from files: multi-page TIFF, NPY, a folder of PNG, or a video file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from analysis.errors import InputError, counted
from analysis.files import FrameBudget, read_json
from analysis.imaging.files.npy_file import read_npy
from analysis.imaging.files.png_files import read_pngs
from analysis.imaging.files.tiff_file import read_tiff
from analysis.imaging.files.video_file import read_video

TIFF_SUFFIXES = (".tif", ".tiff")
VIDEO_SUFFIXES = (".avi", ".mkv", ".mp4")
SUFFIXES = (*TIFF_SUFFIXES, ".npy", *VIDEO_SUFFIXES)


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
    notes
        What about the file could not be checked.
    """

    pixels: NDArray[np.uint8]
    times_s: NDArray[np.float64] | None
    notes: tuple[str, ...] = ()


def read_stack(path: Path) -> FrameStack:
    """Read the frames of one shot.

    Recorded times are taken from a JSON file of the same name beside the frames
    (`times_s`, docs/reference/wire-protocols.md), if there is one.

    Raises
    ------
    InputError
        The file is absent, of another kind, damaged, shorter than it says, or does not hold 8-bit
        grey frames; with the frame where one is at fault. The PNG of a folder whose names give no
        order. More than `file_limits` allow.
    """
    if not path.exists():
        raise InputError(path, "no such file or folder")
    try:
        pixels, notes = _read(path)
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror or error}") from error
    if pixels.ndim != 3 or pixels.dtype != np.uint8:
        raise InputError(
            path,
            f"holds {pixels.dtype} values of shape {pixels.shape}; 8-bit grey frames (frames, "
            "rows, columns) are needed",
        )
    if pixels.size == 0:
        raise InputError(path, "holds no frames")
    return FrameStack(np.ascontiguousarray(pixels), _recorded_times(path, len(pixels)), notes)


def _read(path: Path) -> tuple[NDArray[np.uint8], tuple[str, ...]]:
    budget, suffix = FrameBudget(path), path.suffix.lower()
    if path.is_dir():
        return _stacked(path, read_pngs(path, budget)), ()
    if suffix in TIFF_SUFFIXES:
        return _stacked(path, read_tiff(path, budget)), ()
    if suffix == ".npy":
        return np.asarray(read_npy(path, budget)), ()
    if suffix in VIDEO_SUFFIXES:
        pages, notes = read_video(path, budget)
        return _stacked(path, pages), notes
    raise InputError(path, f"frames are read from {', '.join(SUFFIXES)} or a folder of PNG")


def _stacked(path: Path, pages: list[NDArray[np.generic]]) -> NDArray[np.uint8]:
    if not pages:
        raise InputError(path, "holds no frames")
    for index, page in enumerate(pages):
        if page.shape != pages[0].shape or page.dtype != pages[0].dtype:
            raise InputError(
                path,
                f"frame {index} is {page.dtype} of shape {page.shape}, the first is "
                f"{pages[0].dtype} of shape {pages[0].shape}",
            )
    stacked = np.empty((len(pages), *pages[0].shape), dtype=pages[0].dtype)
    # Each page is let go once it is copied: frames are never held twice.
    while pages:
        page = pages.pop()
        stacked[len(pages)] = page
    return cast("NDArray[np.uint8]", stacked)


def _recorded_times(path: Path, frames: int) -> NDArray[np.float64] | None:
    beside = path.with_suffix(".json")
    if path.is_dir() or not beside.exists():
        return None
    document = read_json(beside)
    try:
        times = np.array(document["times_s"], dtype=np.float64)  # type: ignore[index]
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(beside, f"does not hold times_s as a list of seconds: {error}") from error
    if times.shape != (frames,):
        raise InputError(
            beside, f"times_s has {counted(times.size, 'time')} for {counted(frames, 'frame')}"
        )
    return np.asarray(times - times[0])
