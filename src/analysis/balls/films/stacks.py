"""Films in files of pictures: folders of PNG, TIFF or DNG, multi-page TIFF, NPY.

A DNG is a TIFF of what the sensor saw, a mosaic of colours or grey; a Chronos writes one a frame,
plain. The mosaic is filled in by bilinear means, which move no edge. Values stay the sensor's own:
light, no tone curve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

import cv2
import numpy as np
import tifffile
from numpy.typing import NDArray

from analysis.balls.films.film import Film, FilmHead, Picture
from analysis.errors import InputError
from analysis.files import FrameBudget
from analysis.imaging.files.npy_file import read_npy
from analysis.imaging.files.png_files import numbered_files, read_picture
from analysis.imaging.files.tiff_file import read_tiff

MOSAIC, GREY = 32803, (0, 1, 34892)
"""Photometric interpretations of what is read (DNG specification 1.6)."""
PREVIEW = 1
BAYER = {
    (0, 1, 1, 2): cv2.COLOR_BayerBG2BGR,
    (1, 0, 2, 1): cv2.COLOR_BayerGB2BGR,
    (1, 2, 0, 1): cv2.COLOR_BayerGR2BGR,
    (2, 1, 1, 0): cv2.COLOR_BayerRG2BGR,
}
"""Red 0, green 1, blue 2 of the first two rows; OpenCV names what stands in rows 1 and 2."""


def read_dng(file: Path, budget: FrameBudget) -> NDArray[np.generic]:
    """Return one raw picture, grey or blue, green, red.

    Raises
    ------
    InputError
        Damaged, beyond the budget, compressed, or its first picture is a preview or of a kind that
        is not read.
    """
    page = read_tiff(file, budget)[0]
    kind, pattern, is_preview = _described(file)
    if is_preview:
        raise InputError(
            file, "its first picture is a preview; save the raw pictures without previews"
        )
    if page.ndim == 3 and page.shape[2] > 2:
        return page[..., 2::-1]
    if kind in GREY or page.ndim == 3:
        return page
    if kind != MOSAIC or pattern not in BAYER or page.dtype not in (np.uint8, np.uint16):
        raise InputError(
            file,
            f"photometric interpretation {kind}, colours {pattern}, {page.dtype} values; read are "
            "grey pictures and mosaics of 2 x 2 of red, green and blue, of 8 or 16 bits",
        )
    if min(page.shape) < 4:
        raise InputError(file, f"holds a mosaic of shape {page.shape}; 4 x 4 are needed at least")
    mosaic = cast("Picture", np.ascontiguousarray(page, dtype=page.dtype.newbyteorder("=")))
    return np.asarray(cv2.demosaicing(mosaic, BAYER[pattern]))


def read_exposure(file: Path) -> float | None:
    """Return the exposure, s, that a raw picture states; None: it states none.

    Source: tag ExposureTime (33434), among the picture's own or in its Exif directory (DNG
    specification 1.6). A rate of frames (51044) is the player's, and is not taken.

    Raises
    ------
    InputError
        Its tags cannot be read.
    """
    try:
        with tifffile.TiffFile(file, _multifile=False) as tiff:
            tags = tiff.pages.first.tags
            stated = tags.valueof("ExposureTime", None)
            stated = stated or tags.valueof("ExifTag", {}).get("ExposureTime")
    # A damaged file makes the library raise whatever its parser stumbles over.
    except Exception as error:
        raise InputError(file, f"its tags cannot be read: {error}") from error
    if not isinstance(stated, tuple) or len(stated) != 2 or 0 in stated:
        return None
    return float(stated[0]) / float(stated[1])


def _described(file: Path) -> tuple[int, tuple[int, ...], bool]:
    """Return photometric interpretation, pattern of colours, and whether it is a preview."""
    try:
        with tifffile.TiffFile(file, _multifile=False) as tiff:
            page = tiff.pages.first
            tags = page.tags
            raw = tags.valueof("CFAPattern", b"")
            side = tags.valueof("CFARepeatPatternDim", (2, 2))
            kind = int(page.photometric)
            is_preview = bool(int(tags.valueof("NewSubfileType", 0)) & PREVIEW)
            pattern = tuple(raw) if tuple(side) == (2, 2) else ()
    # A damaged file makes the library raise whatever its parser stumbles over.
    except Exception as error:
        raise InputError(file, f"its tags cannot be read: {error}") from error
    return kind, pattern, is_preview


TIFF_SUFFIXES = (".tif", ".tiff")
RAW_SUFFIX = ".dng"
RED_FIRST = (*TIFF_SUFFIXES, ".npy")
PICTURE_SUFFIXES = (".png", *TIFF_SUFFIXES, RAW_SUFFIX)


class PictureFolder(Film):
    """A folder of pictures in the order of the numbers in their names.

    Raises
    ------
    InputError
        The folder holds no pictures, pictures of several kinds, or names that give no order.
    """

    def __init__(self, path: Path) -> None:
        suffixes = {file.suffix.lower() for file in path.iterdir()} & set(PICTURE_SUFFIXES)
        if not suffixes:
            raise InputError(path, f"a folder without pictures ({', '.join(PICTURE_SUFFIXES)})")
        if len(suffixes) > 1:
            kinds = " and ".join(sorted(suffixes))
            raise InputError(path, f"holds pictures of several kinds: {kinds}; keep one of them")
        suffix = suffixes.pop()
        self._files = numbered_files(path, suffix)
        FrameBudget(path).require_frames(len(self._files))
        height, width, channels = read_one(self._files[0]).shape
        head = FilmHead(len(self._files), height, width, channels)
        if suffix == RAW_SUFFIX:
            head = replace(head, exposure_s=read_exposure(self._files[0]))
        super().__init__(path, head)

    def _read(self) -> Iterator[Picture]:
        head = self.head
        for file in self._files:
            picture = read_one(file)
            if picture.shape != (head.height, head.width, head.channels):
                first = f"({head.height}, {head.width}, {head.channels})"
                raise InputError(file, f"is of shape {picture.shape}, the first is of {first}")
            yield picture


class PictureStack(Film):
    """Pictures of one file that is read whole."""

    def __init__(
        self, path: Path, read: Callable[[Path, FrameBudget], Sequence[NDArray[np.generic]]]
    ) -> None:
        pages = read(path, FrameBudget(path))
        if len(pages) == 0:
            raise InputError(path, "holds no frames")
        pictures = [_picture(path, page) for page in pages]
        if len({picture.shape for picture in pictures}) > 1:
            raise InputError(path, "its frames differ in size")
        height, width, channels = pictures[0].shape
        super().__init__(path, FilmHead(len(pictures), height, width, channels))
        self._pictures = pictures

    def _read(self) -> Iterator[Picture]:
        yield from self._pictures


def read_npy_frames(path: Path, budget: FrameBudget) -> list[NDArray[np.generic]]:
    """Return the frames of an NPY file, (frames, rows, columns), or with red, green, blue."""
    return list(read_npy(path, budget))


def read_one(file: Path) -> Picture:
    """Return one picture of 8 or 16 bits; raise `InputError` where it cannot be read."""
    budget = FrameBudget(file)
    try:
        suffix = file.suffix.lower()
        if suffix == RAW_SUFFIX:
            return _picture(file, read_dng(file, budget))
        tiff = suffix in TIFF_SUFFIXES
        page = read_tiff(file, budget)[0] if tiff else read_picture(file, budget)
    except OSError as error:
        raise InputError(file, f"cannot be read: {error.strerror or error}") from error
    return _picture(file, page)


def _picture(path: Path, page: NDArray[np.generic]) -> Picture:
    """Return a picture of one or three channels (blue, green, red) of 8 or 16 bits."""
    if page.ndim == 2:
        page = page[..., None]
    if page.ndim != 3 or page.dtype not in {np.dtype(np.uint8), np.dtype(np.uint16)}:
        raise InputError(
            path,
            f"holds {page.dtype} values of shape {page.shape}; pictures of 8 or 16 bits (rows, "
            "columns) or (rows, columns, channels) are needed",
        )
    channels = {1: 1, 2: 1, 3: 3, 4: 3}.get(page.shape[2])
    if channels is None or 0 in page.shape:
        raise InputError(path, f"holds pictures of shape {page.shape}")
    page = page[..., :channels]
    # These have red first, what OpenCV reads has blue first.
    if channels == 3 and path.suffix.lower() in RED_FIRST:
        page = page[..., ::-1]
    return cast("Picture", np.ascontiguousarray(page))
