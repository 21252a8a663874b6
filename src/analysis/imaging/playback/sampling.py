"""Pictures of the recorder from the frames, or the fields, of a grabber."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.fields import Scan, parities


@dataclass(frozen=True, slots=True)
class Sampling:
    """Where a grabber's frame holds the recorder's picture, and in which order it was taken.

    Attributes
    ----------
    crop
        First row and column, rows and columns of the picture within the frame.
    rows, columns
        Size of the recorder's picture.
    scan
        Two fields of a frame may show two pictures: each is brought to the whole picture.
    """

    crop: tuple[int, int, int, int]
    rows: int
    columns: int
    scan: Scan = "progressive"

    @property
    def fields(self) -> Literal[1, 2]:
        """Fields of one frame: 1 or 2."""
        return 1 if self.scan == "progressive" else 2

    def pictures(self, frame: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
        """Return what each field of a frame shows, in the order of time, shape (rows, columns).

        A pixel is the mean of what it covers; a line of a field covers two rows of the frame.
        """
        top, left, high, wide = self.crop
        part = frame[top : top + high, left : left + wide].astype(np.float64)
        across = part @ _cover(wide, self.columns, 1, 0).T
        if self.scan == "progressive":
            return [_grey(_cover(high, self.rows, 1, 0) @ across)]
        # Whether a row of the part belongs to the field of even rows depends on where it begins.
        firsts = [(parity + top) % 2 for parity in parities(self.scan)]
        return [_grey(_cover(high, self.rows, 2, first) @ across[first::2]) for first in firsts]


def _cover(lines: int, pixels: int, step: int, parity: int) -> NDArray[np.float64]:
    """Return by how much each pixel covers each line, shape (pixels, lines), rows of sum 1.

    Lines are every `step`-th of so many, from `parity`; each is `step` rows high about its centre.
    """
    centres = np.arange(parity, lines, step) + 0.5
    edges = np.linspace(0.0, lines, pixels + 1)
    low = np.maximum(edges[:-1, None], centres - step / 2)
    high = np.minimum(edges[1:, None], centres + step / 2)
    overlap = np.clip(high - low, 0.0, None)
    return np.asarray(overlap / overlap.sum(axis=1, keepdims=True))


def _grey(picture: NDArray[np.float64]) -> NDArray[np.uint8]:
    return np.rint(picture).astype(np.uint8)
