"""Shots left out by blocks that share their surroundings: a film, a day, a run of the order.

Neighbours share what drifts, and a form that only follows a drift foretells them well. It has to
foretell whole blocks that it has not seen.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.tables import Data

BLOCKS = 8
NAMED = ("film", "day", "session", "batch", "run")
"""Columns of the shot list that say which shots belong together."""


def blocks_of(data: Data) -> NDArray[np.intp]:
    """Return the block of each shot, shape (S,): as a column names them, else runs of shots."""
    for name in NAMED:
        if name in data.covariates:
            _, block = np.unique(data.covariates[name], return_inverse=True)
            if block.max() >= 2:
                return np.asarray(block, dtype=np.intp)
    order = np.argsort(np.argsort(data.shots))
    return np.asarray(order * BLOCKS // len(order), dtype=np.intp)
