"""Candidates for discs: every edge point votes for centres along its direction."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.compiled import compiled

RADIUS_STEP = 1.05
BLUR = 0.06
"""Width of the blur of votes in radii; narrower ones lose ragged rims."""
LEAST_SHARE = 0.09
"""Of the rim that votes for a centre."""
MOST_CANDIDATES = 300


def candidates(
    edges: Singles, shape: tuple[int, int], radii: tuple[float, float], most: int = MOST_CANDIDATES
) -> Floats:
    """Return places where many edge points point to, the best first.

    Bright discs on dark ground and dark ones on bright ground are counted apart: else the two
    sides of a line vote together.

    Parameters
    ----------
    edges
        Of `gradient`.
    radii
        Smallest and largest, pixels.

    Returns
    -------
    Share of the rim, row, column, radius; shape (N, 4).
    """
    low, high = radii
    steps = max(1, int(np.ceil(np.log(high / low) / np.log(RADIUS_STEP)))) + 1
    found: list[Floats] = []
    for radius in np.geomspace(low, high, steps).tolist():
        margin = int(np.ceil(radius))
        for side in (1.0, -1.0):
            votes = np.zeros((shape[0] + 2 * margin, shape[1] + 2 * margin), np.float32)
            _vote(votes, edges, radius, side, margin)
            width = max(0.7, BLUR * radius)
            votes = np.asarray(cv2.GaussianBlur(votes, (0, 0), width), dtype=np.float32)
            # A point's vote counts as it would at the centre of a rim that is exact to the blur.
            votes *= 2.0 * np.pi * width**2 * _PEAK
            top = cv2.dilate(votes, np.ones((5, 5), np.uint8))
            rows, columns = np.nonzero((votes >= top) & (votes >= LEAST_SHARE))
            if len(rows):
                share = votes[rows, columns]
                place = np.stack(
                    [share, rows - margin, columns - margin, np.full(len(rows), radius)], axis=1
                )
                found.append(place.astype(np.float64))
    if not found:
        return np.empty((0, 4))
    every = np.concatenate(found)
    return np.asarray(every[np.argsort(-every[:, 0], kind="stable")][:most])


_PEAK = 0.6
"""Height of a whole rim's peak: its points scatter about as wide as the blur."""


@compiled
def _vote(
    votes: NDArray[np.float32],
    edges: NDArray[np.float32],
    radius: float,
    side: float,
    margin: int,
) -> None:
    """Add votes, a whole rim's together 1; a margin about the picture takes centres outside."""
    rows, columns = votes.shape
    weight = 1.0 / (2.0 * np.pi * radius)
    for point in edges:
        row = point[0] + side * radius * point[2] + margin
        column = point[1] + side * radius * point[3] + margin
        i, j = int(row), int(column)
        if i < 0 or j < 0 or i + 1 >= rows or j + 1 >= columns:
            continue
        p, q = row - i, column - j
        votes[i, j] += weight * (1 - p) * (1 - q)
        votes[i + 1, j] += weight * p * (1 - q)
        votes[i, j + 1] += weight * (1 - p) * q
        votes[i + 1, j + 1] += weight * p * q
