"""Rows and columns of the sensor that see nothing, filled from those beside them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Grey, grey_like

FEW = 9
"""Frames that are looked at."""
CHANGES, STILL = 15.0, 6.0
"""Range over those frames in units of the noise: at least, where spheres pass; noise alone."""
LEAST_SHARE, LEAST_PASSED = 0.9, 8
"""Of a line's pixels that stand still although those beside them change, and how many do."""
WIDEST = 2
"""Dead lines side by side."""


def dead_lines(frames: Grey, noise: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the rows and the columns that do not change although those on either side do.

    A line that no sphere passes is left alone: it does no harm.

    Parameters
    ----------
    frames
        Grey levels, shape (frames, rows, columns).
    noise
        Standard deviation of a pixel, grey levels.
    """
    few = frames[:: max(1, len(frames) // FEW)][:FEW]
    change: Grey = few.max(axis=0) - few.min(axis=0)
    return _blind(change, noise), _blind(change.T, noise)


def _blind(change: Grey, noise: float) -> NDArray[np.intp]:
    """Return the rows that do not follow, of the range of each pixel."""
    around = np.pad(change, ((WIDEST, WIDEST), (0, 0)))
    count = len(change)
    before = np.maximum(around[:count], around[1 : count + 1])
    after = np.maximum(around[WIDEST + 1 : -1], around[2 * WIDEST :])
    passed = np.minimum(before, after) > CHANGES * noise
    frozen = passed & (change < STILL * noise)
    often = passed.sum(axis=1)
    return np.flatnonzero((often >= LEAST_PASSED) & (frozen.sum(axis=1) >= LEAST_SHARE * often))


def filled(frames: Grey, noise: float) -> Grey:
    """Return the frames with dead lines filled in from the nearest live ones on either side.

    A line of a disc at the sensor's own grey level cuts the edges of the start and pulls at the
    pose. What is filled in is wrong by the bend of the image across the line. The same array
    comes back where every line sees.

    Parameters
    ----------
    frames, noise
        As for `dead_lines`.
    """
    rows, columns = dead_lines(frames, noise)
    if not len(rows) and not len(columns):
        return frames
    whole = frames.copy()
    _fill(whole, rows)
    _fill(whole.transpose(0, 2, 1), columns)
    return whole


def _fill(frames: Grey, dead: NDArray[np.intp]) -> None:
    """Fill rows in place, linearly between the live ones."""
    live = np.setdiff1d(np.arange(frames.shape[1]), dead)
    for row in dead:
        after = int(np.searchsorted(live, row))
        low, high = live[after - 1], live[after]
        share = (row - low) / (high - low)
        mixed = (1.0 - share) * frames[:, low] + share * frames[:, high]
        frames[:, row] = grey_like(mixed, frames)
