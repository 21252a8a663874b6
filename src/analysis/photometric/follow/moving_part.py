"""The part of the pictures in which spheres move: all of a large picture that is worth looking at.

Background, noise, votes and masks cost a pixel each, wherever it lies; most of a picture of a
million pixels never shows a sphere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Grey
from analysis.photometric.learn.appearance import Appearance

BLOCK_PX, EVERY = 8, 4
"""Of its rows these are looked at."""
CHANGES, LEAST_CHANGE = 2.0, 1.0
"""Mean range of a block that something passes: in that of the median block, and grey levels more.
Noise alone gives each block the same range within a tenth."""
MOST_OF_PICTURE = 0.5
"""A larger part saves less than its cutting costs."""


@dataclass(frozen=True, slots=True)
class Part:
    """A rectangle of a picture: half-open ranges of rows and columns."""

    rows: tuple[int, int]
    columns: tuple[int, int]

    def of(self, frames: Grey) -> Grey:
        """Return this part of frames, shape (frames, rows, columns)."""
        return frames[:, slice(*self.rows), slice(*self.columns)]

    def shown(self, known: Appearance) -> Appearance:
        """Return a pair as its camera shows it in pixels of this part."""
        optics = known.camera.optics
        top, left = self.rows[0], self.columns[0]
        optics = optics._replace(
            origins=optics.origins - np.array([top, left]),
            rows=np.clip(optics.rows - top, 0, self.rows[1] - top),
            middle=(optics.middle[0] - top, optics.middle[1] - left),
        )
        return replace(known, camera=replace(known.camera, optics=optics))

    def whole(self, shown: Appearance, known: Appearance) -> Appearance:
        """Return a pair that was learned in this part in pixels of the picture `known` is of."""
        optics = shown.camera.optics
        optics = optics._replace(
            origins=optics.origins + np.array([self.rows[0], self.columns[0]]),
            rows=known.camera.optics.rows,
            middle=known.camera.optics.middle,
        )
        return replace(shown, camera=replace(shown.camera, optics=optics))


def moving_part(frames: Grey, known: Appearance) -> Part | None:
    """Find the part of the pictures that a pair's spheres pass.

    None where nothing moves, or where most of the picture does. The part reaches a diameter
    beyond what changes: a sphere may be as bright as what is behind it on one side.

    Parameters
    ----------
    frames
        Grey levels, shape (frames, rows, columns).
    """
    changing = _changing(frames)
    if not changing.any():
        return None
    radius = max(sphere.radius_m for sphere in known.spheres) * known.camera.optics.scales.max()
    around = int(np.ceil(2.0 * radius))
    ranges = []
    for axis, most in ((1, frames.shape[1]), (0, frames.shape[2])):
        blocks = np.flatnonzero(changing.any(axis=axis))
        low = max(0, int(blocks[0]) * BLOCK_PX - around)
        ranges.append((low, min(most, (int(blocks[-1]) + 1) * BLOCK_PX + around)))
    (top, bottom), (left, right) = ranges
    if (bottom - top) * (right - left) > MOST_OF_PICTURE * frames[0].size:
        return None
    return Part((top, bottom), (left, right))


def _changing(frames: Grey) -> NDArray[np.bool_]:
    """Return in which blocks of the picture something passes; the last rows may make none."""
    seen = frames[:, ::EVERY]
    change = seen.max(axis=0) - seen.min(axis=0)
    high = BLOCK_PX // EVERY
    down, across = change.shape[0] // high, change.shape[1] // BLOCK_PX
    blocks = change[: down * high, : across * BLOCK_PX]
    means = blocks.reshape(down, high, across, BLOCK_PX).mean(axis=(1, 3))
    if means.size == 0:
        return np.zeros((down, across), dtype=np.bool_)
    return np.asarray(means > CHANGES * np.median(means) + LEAST_CHANGE)
