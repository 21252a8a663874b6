"""Arrays of numbers, as most of the analysis takes and gives them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

Singles = NDArray[np.float32]

Grey = NDArray[np.uint8] | Singles
"""Grey levels on the scale of 8 bits; with fractions where a camera has more bits."""


def as_singles(frames: Grey) -> Singles:
    """Return grey levels as compiled functions take them, contiguous in rows and writable.

    They see one type, whatever the camera's depth: for another each would be compiled once more.
    Every whole level is a single exactly. The same array where it is so already.
    """
    return np.require(frames, np.float32, ["C", "W"])


def grey_like(values: Floats, kind: Grey) -> Grey:
    """Return values as grey levels of the type of `kind`: rounded where it has whole ones alone."""
    held = np.clip(values, 0.0, 255.0)
    return np.rint(held).astype(np.uint8) if kind.dtype == np.uint8 else held.astype(np.float32)
