"""Places to which many edge points point: where discs may be."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.compiled import compiled

RADIUS_STEP = 1.05
BLUR = 0.06
"""Width of the blur of votes in radii; narrower ones lose ragged rims."""
LEAST_SHARE, CLEAR_SHARE = 0.07, 0.09
"""Of the rim that votes for a centre: beside clutter, and without."""
MOST_CLEAR = 300
"""Candidates of one size without clutter."""
MOST_CANDIDATES, MOST_NEAR, PATCH = 600, 12, 8.0
"""Of one size; and in a square patch with this side in smallest radii, so that clutter at one place
leaves room for what is elsewhere."""
SAME_PX, SAME_PLACE = 1.0, 0.12
"""Candidates of neighbouring radii are one where they are nearer, in pixels at least and in
radii."""


def candidates(
    edges: Singles,
    shape: tuple[int, ...],
    radii: tuple[float, float],
    *,
    cluttered: bool = True,
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
    cluttered
        Whether there is a ground whose clutter votes as well: more places are looked at then, and
        not too many of one patch.

    Returns
    -------
    Share of the rim, row, column, radius; shape (N, 4).
    """
    low, high = radii
    least = LEAST_SHARE if cluttered else CLEAR_SHARE
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
            peaks = cv2.findNonZero(((votes >= top) & (votes >= least)).astype(np.uint8))
            if peaks is not None:
                columns, rows = peaks.reshape(-1, 2).T
                share = votes[rows, columns]
                place = np.stack(
                    [share, rows - margin, columns - margin, np.full(len(rows), radius)], axis=1
                )
                found.append(place.astype(np.float64))
    if not found:
        return np.empty((0, 4))
    every = np.concatenate(found)
    every = every[np.argsort(-every[:, 0], kind="stable")]
    if not cluttered:
        return np.asarray(every[:MOST_CLEAR])
    return np.asarray(every[_spread_out(every, max(1.0, PATCH * low))])


@compiled
def _spread_out(places: NDArray[np.float64], patch_px: float) -> NDArray[np.int64]:
    """Return which places are kept, each once and not too many of a patch, the best first."""
    kept = np.empty(MOST_CANDIDATES, np.int64)
    count = 0
    lowest = np.array([places[:, 1].min(), places[:, 2].min()])
    rows = int((places[:, 1].max() - lowest[0]) / patch_px) + 1
    columns = int((places[:, 2].max() - lowest[1]) / patch_px) + 1
    near = np.zeros((rows, columns), np.int64)
    for k in range(len(places)):
        _, row, column, radius = places[k]
        i, j = int((row - lowest[0]) / patch_px), int((column - lowest[1]) / patch_px)
        if near[i, j] >= MOST_NEAR:
            continue
        same = False
        for m in range(count):
            _, other_row, other_column, other_radius = places[kept[m]]
            apart = math.hypot(row - other_row, column - other_column)
            ratio = max(radius, other_radius) / min(radius, other_radius)
            if ratio < RADIUS_STEP**1.5 and apart < max(SAME_PX, SAME_PLACE * radius):
                same = True
                break
        if same:
            continue
        near[i, j] += 1
        kept[count] = k
        count += 1
        if count == MOST_CANDIDATES:
            break
    return kept[:count]


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
