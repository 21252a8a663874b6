"""Frames from files: multi-page TIFF, NPY, a folder of PNG, or a video file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Grey
from analysis.errors import InputError, counted
from analysis.files import FrameBudget, read_json
from analysis.imaging.files.npy_file import read_npy
from analysis.imaging.files.png_files import SUFFIX as PNG_SUFFIX
from analysis.imaging.files.png_files import read_pngs, refuse_single
from analysis.imaging.files.tiff_file import read_tiff
from analysis.imaging.files.video_file import ColourError, read_video

TIFF_SUFFIXES = (".tif", ".tiff")
VIDEO_SUFFIXES = (".avi", ".mkv", ".mp4")
USUAL_BITS = (8, 10, 12, 14, 16)
"""Of a pixel that a camera gives."""
SUFFIXES = (*TIFF_SUFFIXES, ".npy", *VIDEO_SUFFIXES)


@dataclass(frozen=True, slots=True, eq=False)
class FrameStack:
    """Frames of one shot.

    Attributes
    ----------
    pixels
        8-bit grey levels, shape (frames, rows, columns).
    light
        The same with fractions, where the file has more bits; `pixels` itself where it has 8.
    times_s
        Recorded time of each frame counted from the first, s, where a file beside the frames or a
        camera's own file holds it, else None.
    notes
        What about the file could not be checked.
    exposure_s
        Time the shutter was open, where a camera's own file says so, else None.
    """

    pixels: NDArray[np.uint8]
    light: Grey
    times_s: NDArray[np.float64] | None
    notes: tuple[str, ...] = ()
    exposure_s: float | None = None


def read_stack(path: Path) -> FrameStack:
    """Read the frames of one shot.

    Recorded times are taken from a JSON file of the same name beside the frames
    (`times_s`, docs/reference/wire-protocols.md), if there is one.

    Raises
    ------
    InputError
        The file is absent, of another kind, damaged, shorter than it says, or does not hold grey
        frames of 8 to 16 bits; with the frame where one is at fault. The PNG of a folder whose
        names give no order. More than `file_limits` allow.
    """
    if not path.exists():
        raise InputError(path, "no such file or folder")
    try:
        pixels, notes = _read(path)
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror or error}") from error
    if pixels.ndim == 4 and pixels.shape[3] in {3, 4}:
        raise ColourError(path, f"holds frames in colour of shape {pixels.shape}, not grey frames")
    if pixels.ndim != 3 or pixels.dtype not in {np.dtype(np.uint8), np.dtype(np.uint16)}:
        raise InputError(
            path,
            f"holds {pixels.dtype} values of shape {pixels.shape}; grey frames (frames, rows, "
            "columns) of 8 to 16 bits are needed",
        )
    if pixels.size == 0:
        raise InputError(path, "holds no frames")
    times_s = recorded_times(path, len(pixels))
    if pixels.dtype == np.uint8:
        whole = np.ascontiguousarray(pixels)
        return FrameStack(whole, whole, times_s, notes)
    light, note = on_scale_of_8_bits(pixels, int(pixels.max()))
    return FrameStack(np.rint(light).astype(np.uint8), light, times_s, (*notes, note))


def on_scale_of_8_bits(
    pixels: NDArray[np.generic], largest: int
) -> tuple[NDArray[np.float32], str]:
    """Return values of more bits as grey levels from 0 to 255, fractions kept, and a note on it.

    A camera's bits are the fewest usual ones that hold the largest value of its file. Bits
    below, which some cameras leave empty, do not matter.
    """
    bits = next(b for b in USUAL_BITS if largest < 1 << b)
    scale = np.float32(255.0 / ((1 << bits) - 1))
    note = f"values of up to {largest} are taken for those of {bits} bits; grey levels keep them"
    return np.asarray(pixels, dtype=np.float32) * scale, note


def _read(path: Path) -> tuple[NDArray[np.generic], tuple[str, ...]]:
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
    if suffix == PNG_SUFFIX:
        refuse_single(path)
    raise InputError(path, f"frames are read from {', '.join(SUFFIXES)} or a folder of PNG")


def _stacked(path: Path, pages: list[NDArray[np.generic]]) -> NDArray[np.generic]:
    if not pages:
        raise InputError(path, "holds no frames")
    for index, page in enumerate(pages):
        if page.shape != pages[0].shape or page.dtype != pages[0].dtype:
            raise InputError(
                path,
                f"frame {index} is {page.dtype} of shape {page.shape}, the first is "
                f"{pages[0].dtype} of shape {pages[0].shape}",
            )
    stacked: NDArray[np.generic] = np.empty((len(pages), *pages[0].shape), dtype=pages[0].dtype)
    # Each page is let go once it is copied: frames are never held twice.
    while pages:
        page = pages.pop()
        stacked[len(pages)] = page
    return stacked


def beside_frames(path: Path) -> Path:
    """Return where recorded times of frames would lie: a JSON file of the same name beside them."""
    return path.parent / f"{path.name}.json" if path.is_dir() else path.with_suffix(".json")


def recorded_times(path: Path, frames: int) -> NDArray[np.float64] | None:
    """Return the times beside so many frames, s from the first; None where there are none.

    Raises
    ------
    InputError
        The file holds no list of seconds, or a number of them other than that of the frames.
    """
    beside = beside_frames(path)
    if not beside.exists():
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
