"""Markers scattered on a sphere."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_TRIES = 200
_CANDIDATES = 400


def scatter_markers(
    number: int, rng: np.random.Generator, separation_rad: float = 0.55
) -> NDArray[np.float64]:
    """Draw marker directions at random, none closer to another than `separation_rad`.

    Candidates are drawn uniformly on the sphere and taken one after another where they fit; a
    layout that jams is thrown away and begun again.

    Returns
    -------
    Unit vectors (number, 3) in body axes.

    Raises
    ------
    ValueError
        No layout was found: that many markers do not fit at that separation.
    """
    limit = math.cos(separation_rad)
    for _ in range(_TRIES):
        candidates = rng.normal(size=(_CANDIDATES, 3))
        candidates /= np.linalg.norm(candidates, axis=1, keepdims=True)
        chosen = np.empty((0, 3))
        for candidate in candidates:
            if len(chosen) == number:
                return chosen
            if np.all(chosen @ candidate <= limit):
                chosen = np.vstack([chosen, candidate])
        if len(chosen) == number:
            return chosen
    raise ValueError(
        f"{number} markers do not fit on a sphere {separation_rad} rad apart; "
        "take fewer markers or a smaller separation"
    )
