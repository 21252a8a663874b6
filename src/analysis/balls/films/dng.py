"""Raw pictures (.dng): a TIFF of what the sensor saw, a mosaic of colours or grey.

A Chronos writes them one a frame, plain. The mosaic is filled in by bilinear means, which move no
edge. Values stay the sensor's own: light, no tone curve.
"""

from __future__ import annotations

from pathlib import Path
from typing import cast

import cv2
import numpy as np
import tifffile
from numpy.typing import NDArray

from analysis.balls.films.film import Picture
from analysis.errors import InputError
from analysis.files import FrameBudget
from analysis.imaging.files.tiff_file import read_tiff

MOSAIC, GREY = 32803, (0, 1, 34892)
"""Photometric interpretations of what is read (DNG specification 1.6)."""
PREVIEW = 1
_PATTERNS = {
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
    if kind != MOSAIC or pattern not in _PATTERNS or page.dtype not in (np.uint8, np.uint16):
        raise InputError(
            file,
            f"photometric interpretation {kind}, colours {pattern}, {page.dtype} values; read are "
            "grey pictures and mosaics of 2 x 2 of red, green and blue, of 8 or 16 bits",
        )
    if min(page.shape) < 4:
        raise InputError(file, f"holds a mosaic of shape {page.shape}; 4 x 4 are needed at least")
    mosaic = cast("Picture", np.ascontiguousarray(page, dtype=page.dtype.newbyteorder("=")))
    return np.asarray(cv2.demosaicing(mosaic, _PATTERNS[pattern]))


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
