"""Fits to the least sum of distances, in which edges of other things hardly count."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.balls.discs.gradient import EXACT_PX

LEAST_SUMS = 6
"""Fits with new weights to the least sum of distances."""


def least_sum(terms: list[Floats], values: Floats) -> tuple[Floats, float]:
    """Return the sizes of terms that leave the least sum of sizes of some values, and the sum."""
    matrix = np.column_stack(terms)
    weights = np.ones_like(values)
    for _ in range(LEAST_SUMS):
        found = np.linalg.lstsq(matrix * weights[:, None], values * weights, rcond=None)[0]
        left = np.abs(values - matrix @ found)
        weights = 1.0 / np.sqrt(np.maximum(left, EXACT_PX))
    return np.asarray(found), float(left.sum())
