"""Arrays of numbers, as most of the analysis takes and gives them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

Grey = NDArray[np.uint8] | NDArray[np.float32]
"""Grey levels on the scale of 8 bits; with fractions where a camera has more bits."""


def grey_like(values: Floats, kind: Grey) -> Grey:
    """Return values as grey levels of the type of `kind`: rounded where it has whole ones alone."""
    held = np.clip(values, 0.0, 255.0)
    return np.rint(held).astype(np.uint8) if kind.dtype == np.uint8 else held.astype(np.float32)
