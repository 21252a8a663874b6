"""Frames from files: multi-page TIFF, NPY, a folder of PNG, or a video file."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.errors import InputError, counted
from analysis.imaging.tiff_file import read_tiff
from analysis.imaging.video_file import read_video

TIFF_SUFFIXES = (".tif", ".tiff")
VIDEO_SUFFIXES = (".avi", ".mkv", ".mp4")
SUFFIXES = (*TIFF_SUFFIXES, ".npy", *VIDEO_SUFFIXES)

_NUMBER = re.compile("[0-9]+")


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
        order.
    """
    if not path.exists():
        raise InputError(path, "no such file or folder")
    notes: tuple[str, ...] = ()
    if path.is_dir():
        pixels = _read_folder(path)
    elif path.suffix.lower() in TIFF_SUFFIXES:
        pixels = _stacked(path, read_tiff(path))
    elif path.suffix.lower() == ".npy":
        pixels = _read_npy(path)
    elif path.suffix.lower() in VIDEO_SUFFIXES:
        pages, notes = read_video(path)
        pixels = _stacked(path, pages)
    else:
        raise InputError(path, f"frames are read from {', '.join(SUFFIXES)} or a folder of PNG")
    if pixels.ndim != 3 or pixels.dtype != np.uint8:
        raise InputError(
            path,
            f"holds {pixels.dtype} values of shape {pixels.shape}; 8-bit grey frames (frames, "
            "rows, columns) are needed",
        )
    return FrameStack(np.ascontiguousarray(pixels), _recorded_times(path, len(pixels)), notes)


def _read_npy(path: Path) -> NDArray[np.uint8]:
    try:
        return np.asarray(np.load(path, allow_pickle=False))
    except (ValueError, OSError, EOFError) as error:
        raise InputError(path, f"not a whole NPY file: {error}") from error


def holds_png(folder: Path) -> bool:
    """Return whether a folder could be a shot's frames."""
    return any(path.suffix.lower() == ".png" for path in folder.iterdir())


def _png_files(folder: Path) -> list[Path]:
    """Return the PNG files of a folder in the order of the numbers in their names.

    Raises
    ------
    InputError
        Two names differ in more than their numbers, or have the same numbers.
    """
    names = [path for path in folder.iterdir() if path.suffix.lower() == ".png"]
    names.sort(key=lambda path: (_numbers(path), path.name))
    for first, second in pairwise(names):
        if _NUMBER.sub("#", first.stem) != _NUMBER.sub("#", second.stem):
            why = "differ in more than their numbers"
        elif _numbers(first) == _numbers(second):
            why = "have the same numbers"
        else:
            continue
        raise InputError(
            folder,
            f"{first.name} and {second.name} {why}, which gives no order; name the frames "
            "0000.png, 0001.png and so on",
        )
    return names


def _numbers(path: Path) -> list[int]:
    return [int(digits) for digits in _NUMBER.findall(path.stem)]


def _read_folder(path: Path) -> NDArray[np.uint8]:
    names = _png_files(path)
    if not names:
        raise InputError(path, "a folder without PNG files")
    pages = []
    for name in names:
        page = cv2.imread(str(name), cv2.IMREAD_UNCHANGED)
        if page is None:
            raise InputError(name, "not a whole PNG file")
        pages.append(np.asarray(page))
    return _stacked(path, pages)


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
        raise InputError(
            beside, f"times_s has {counted(times.size, 'time')} for {counted(frames, 'frame')}"
        )
    return np.asarray(times - times[0])
