"""Grey levels of the uncompressed formats that cameras and grabbers give, as 8 bits a pixel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rigctl.config import PixelFormatName

COMPRESSED: Final = ("MJPG", "JPEG", "H264", "HEVC", "MPEG", "VP80", "VP90")
"""Codes of formats whose compression changes grey levels: refused."""


@dataclass(frozen=True, slots=True)
class GreyFormat:
    """Where the grey level of a pixel lies (linux/videodev2.h).

    Attributes
    ----------
    code
        The format's four characters as a little-endian number.
    bytes_per_pixel
        Between one grey level and the next.
    first
        Byte of the first grey level in a line.
    bits
        Of a grey level; above 8 it takes two bytes, the lower first, its bits at the lower end.
    """

    code: int
    bytes_per_pixel: int
    first: int
    bits: int

    def grey(self, lines: NDArray[np.uint8], columns: int) -> NDArray[np.uint8]:
        """Return grey levels, shape (rows, columns), of lines of bytes, shape (rows, bytes).

        More than 8 bits are rounded to 8: half a level at most, below the noise of a sensor.
        """
        used = lines[:, : columns * self.bytes_per_pixel]
        if self.bits == 8:
            return used[:, self.first :: self.bytes_per_pixel]
        levels = np.ascontiguousarray(used).view("<u2")
        shift = self.bits - 8
        rounded = (levels.astype(np.uint32) + (1 << (shift - 1))) >> shift
        grey: NDArray[np.uint8] = np.minimum(rounded, 255).astype(np.uint8)
        return grey


def code_of(characters: str) -> int:
    """Return a format's code: its characters, blanks behind them, as a little-endian number."""
    return int.from_bytes(characters.ljust(4).encode("ascii"), "little")


GREY_FORMATS: Final[dict[PixelFormatName, GreyFormat]] = {
    "GREY": GreyFormat(code_of("GREY"), 1, 0, 8),
    "YUYV": GreyFormat(code_of("YUYV"), 2, 0, 8),
    "UYVY": GreyFormat(code_of("UYVY"), 2, 1, 8),
    "Y10": GreyFormat(code_of("Y10"), 2, 0, 10),
    "Y12": GreyFormat(code_of("Y12"), 2, 0, 12),
    "Y16": GreyFormat(code_of("Y16"), 2, 0, 16),
}
"""Of YUYV and UYVY only the brightness is used; it usually runs from 16 to 235."""
