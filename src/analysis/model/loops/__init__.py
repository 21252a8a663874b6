"""Compiled loops over the poses and contacts of many shots.

They take arrays that are contiguous in rows and can be written; `plain` makes any such.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats


def plain(numbers: Floats) -> Floats:
    """Return numbers as a compiled loop takes them, copied where they are not so yet."""
    return np.require(numbers, np.float64, ("C", "W"))
