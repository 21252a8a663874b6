"""Films without a header, as a Chronos saves them: a person states what their pictures are.

Pixels of 16 bits are little-endian. Of 12 bits packed, as firmware 0.3.1 and later writes them,
three bytes hold two pixels: 0x123 and 0xabc are 0x23, 0x1c, 0xab (Krontech's pyraw2dng and the
LTRAC laboratory's pySciCam have it alike).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.balls.films.film import Film, FilmHead, Picture
from analysis.balls.films.stacks import BAYER
from analysis.errors import InputError
from analysis.files import FrameBudget

RAW_FILM_SUFFIX = ".raw"
LAYOUT = re.compile(r"(\d+)x(\d+)x(12|16)(?::([RGB]{4}))?")
EXAMPLE = "1280x1024x12, or with the colours of the first 2 x 2 pixels 1280x1024x12:GBRG"


@dataclass(frozen=True, slots=True)
class RawLayout:
    """Pictures of a film without a header.

    Attributes
    ----------
    width, height
        px.
    bits
        Of a pixel: 12, packed, or 16.
    colours
        Of the first two pixels in rows 0 and 1, such as GBRG; empty: grey.
    """

    width: int
    height: int
    bits: int
    colours: str = ""

    @classmethod
    def of(cls, said: str) -> RawLayout:
        """Return what `1280x1024x12` or `1280x1024x12:GBRG` states; raise `ValueError`."""
        found = LAYOUT.fullmatch(said.strip())
        if found is None:
            raise ValueError(said)
        width, height, bits = (int(found[k]) for k in (1, 2, 3))
        colours = found[4] or ""
        if min(width, height) < 1 or (bits == 12 and width * height % 2):
            raise ValueError(said)
        if colours and (pattern_of(colours) not in BAYER or min(width, height) < 4):
            raise ValueError(said)
        return cls(width, height, bits, colours)

    @property
    def frame_bytes(self) -> int:
        """How many bytes one picture has."""
        return self.width * self.height * self.bits // 8


class RawFilm(Film):
    """A film without a header.

    Raises
    ------
    InputError
        The file is no whole number of such pictures.
    """

    def __init__(self, path: Path, layout: RawLayout) -> None:
        frames, rest = divmod(path.stat().st_size, layout.frame_bytes)
        if rest or not frames:
            raise InputError(
                path,
                f"{path.stat().st_size} bytes are {frames} pictures of {layout.width} x "
                f"{layout.height} pixels of {layout.bits} bits and {rest} bytes more; state what "
                "they are with --raw",
            )
        self._layout = layout
        channels = 3 if layout.colours else 1
        budget = FrameBudget(path)
        budget.require_frames(frames)
        budget.claim((layout.height, layout.width, channels), 2)
        super().__init__(path, FilmHead(frames, layout.height, layout.width, channels))

    def _read(self) -> Iterator[Picture]:
        layout = self._layout
        with self.path.open("rb") as file:
            for _ in range(self.head.frames):
                content = file.read(layout.frame_bytes)
                packed = layout.bits == 12
                values = unpacked_pairs(content) if packed else np.frombuffer(content, "<u2")
                picture = values.astype(np.uint16).reshape(layout.height, layout.width)
                if layout.colours:
                    yield cast(
                        "Picture", cv2.demosaicing(picture, BAYER[pattern_of(layout.colours)])
                    )
                else:
                    yield picture[..., None]


def pattern_of(colours: str) -> tuple[int, int, int, int]:
    """Return red 0, green 1, blue 2 of the first two rows."""
    a, b, c, d = ("RGB".index(colour) for colour in colours)
    return a, b, c, d


def unpacked_pairs(content: bytes) -> NDArray[np.uint16]:
    """Return pixels of 12 bits, of which three bytes hold two."""
    low, both, high = np.frombuffer(content, np.uint8).reshape(-1, 3).T.astype(np.uint16)
    pairs = low | (both >> 4) << 8, high << 4 | both & 0x0F
    return np.asarray(np.stack(pairs, axis=1).ravel(), dtype=np.uint16)
