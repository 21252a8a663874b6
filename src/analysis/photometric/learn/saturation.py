"""Frames whose sensor was full: shading that is cut off cannot be learned."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.errors import ShotRefusedError

MOST_FULL = 0.5
"""Share of the bright pixels. A highlight fills a few percent; with half of the discs cut off the
limb shifts by some tenths of a pixel, and the residuals do not show it."""


def refuse_full(frames: NDArray[np.uint8]) -> None:
    """Refuse frames in which most of what is bright has one and the same grey level.

    Raises
    ------
    ShotRefusedError
        With the share and the grey level.
    """
    counts = np.bincount(frames.ravel(), minlength=256)
    top = int(np.flatnonzero(counts)[-1])
    middle = int(np.searchsorted(counts.cumsum(), frames.size / 2))
    bright = int(counts[(top + middle) // 2 + 1 :].sum())
    share = counts[top] / bright if bright else 0.0
    if share > MOST_FULL:
        raise ShotRefusedError(
            "frames",
            f"{100 * share:.0f} % of the bright pixels are full at grey level {top}, "
            f"{100 * MOST_FULL:.0f} % are allowed; take less light or a shorter exposure",
        )
