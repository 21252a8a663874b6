"""Where the discs are, to about a pixel: each edge point votes for a centre along its normal.

The circle Hough transform with gradient direction (thesis, section 2.2.2; C. Kimme, D. Ballard and
J. Sklansky, "Finding circles by an array of accumulators", Comm. ACM 18, 120-122 (1975),
doi:10.1145/360666.360677). It only starts the fit of the outline.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.imaging.edge.facet import EdgePoints
from analysis.imaging.limb import Edges

Indices = NDArray[np.intp]

BLUR_PX, HALF_BLUR = 1.3, 5
HALF_PEAK = 2
"""A peak's place is the middle of the votes within this many pixels."""
NO_VOTES = 1e-30
PADDING_PX = 24
"""Votes may fall outside the frame: a disc half out of view still has its centre found."""


@dataclass(frozen=True, slots=True)
class Disc:
    """A disc found in a frame: centre in pixels and the share of its rim that voted for it."""

    row: float
    column: float
    rim_share: float


ALIKE = 1.1
"""Discs whose radii differ by a smaller factor are not told apart by their votes."""


def vote_radii(radii_px: tuple[float, float]) -> tuple[float, float]:
    """Return the radii to vote for: the mean one twice where two spheres are nearly alike."""
    if max(radii_px) < ALIKE * min(radii_px):
        return (sum(radii_px) / 2,) * 2
    return radii_px


def pair_apart(
    first: Sequence[Disc], second: Sequence[Disc], apart_px: float
) -> tuple[Disc, Disc] | None:
    """Return one disc of each list that lie apart and show most of their rims; None without any."""
    pairs = [
        (a, b)
        for a, b in product(first, second)
        if math.hypot(a.row - b.row, a.column - b.column) >= apart_px
    ]
    return max(pairs, key=lambda pair: pair[0].rim_share + pair[1].rim_share, default=None)


def vote(points: EdgePoints, radius_px: float, shape: tuple[int, int]) -> NDArray[np.float32]:
    """Return the votes for a disc of this radius centred on each pixel, as a share of its rim.

    Votes go both ways along the normal: part of an unevenly lit sphere may be darker than what
    lies behind it.

    Returns
    -------
    Shape (rows + 2 PADDING_PX, columns + 2 PADDING_PX); the frame's pixel (0, 0) lies at
    (PADDING_PX, PADDING_PX).
    """
    rows, columns = shape[0] + 2 * PADDING_PX, shape[1] + 2 * PADDING_PX
    image = np.zeros((rows, columns), dtype=np.float32)
    count_votes(
        points.row,
        points.column,
        radius_px * points.normal_row,
        radius_px * points.normal_column,
        image,
    )
    blurred = cv2.GaussianBlur(image, (0, 0), BLUR_PX, borderType=cv2.BORDER_CONSTANT)
    # The blur spreads a full rim's 2 pi R votes over 2 pi BLUR_PX^2 pixels.
    return np.asarray(blurred * (BLUR_PX**2 / radius_px), dtype=np.float32)


@compiled
def count_votes(
    row: Floats, column: Floats, down: Floats, across: Floats, image: NDArray[np.float32]
) -> None:
    """Count for each pixel of a padded image the points that lie (down, across) from it."""
    for k in range(row.size):
        for side in (1.0, -1.0):
            r = int(np.rint(row[k] + side * down[k])) + PADDING_PX
            c = int(np.rint(column[k] + side * across[k])) + PADDING_PX
            if 0 <= r < image.shape[0] and 0 <= c < image.shape[1]:
                image[r, c] += 1.0


def discs(votes: NDArray[np.float32], least_share: float, separation_px: float) -> list[Disc]:
    """Return the peaks of a vote image, strongest first, each to a fraction of a pixel."""
    peaks = summits(votes, least_share, int(separation_px))
    found = [_peak(votes, r, c) for r, c in peaks.tolist()]
    return sorted(found, key=lambda disc: -disc.rim_share)


@compiled
def summits(votes: NDArray[np.float32], least_share: float, separation_px: int) -> Indices:
    """Return the pixels that no other within a distance in rows and in columns exceeds.

    Returns
    -------
    Rows and columns, shape (summits, 2).
    """
    peaks, count = np.empty((votes.size, 2), dtype=np.intp), 0
    for r in range(votes.shape[0]):
        for c in range(votes.shape[1]):
            # Most are exceeded by a neighbour, which is soon seen.
            if votes[r, c] < least_share or exceeded(votes, r, c, 1):
                continue
            if not exceeded(votes, r, c, separation_px):
                peaks[count, 0], peaks[count, 1] = r, c
                count += 1
    return peaks[:count].copy()


@part
def exceeded(votes: NDArray[np.float32], r: int, c: int, distance: int) -> bool:
    """Tell whether a pixel has a higher one within a distance in rows and in columns."""
    for y in range(max(r - distance, 0), min(r + distance + 1, votes.shape[0])):
        for x in range(max(c - distance, 0), min(c + distance + 1, votes.shape[1])):
            if votes[y, x] > votes[r, c]:
                return True
    return False


@compiled
def peaks_near(edges: Edges, places: Floats, reach_px: float) -> Floats:
    """Return the strongest peak of the votes about each predicted disc.

    Only the votes about the predictions are counted.

    Parameters
    ----------
    places
        Row, column and radius of each, pixels, shape (discs, 3).
    reach_px
        Largest distance of a peak in rows and in columns.

    Returns
    -------
    Row, column and share of the rim of each, shape (discs, 3).
    """
    peaks, reach = np.empty((places.shape[0], 3)), math.ceil(reach_px)
    size = 2 * (reach + HALF_PEAK + HALF_BLUR) + 1
    taps = np.exp(-0.5 * (np.arange(-HALF_BLUR, HALF_BLUR + 1) / BLUR_PX) ** 2)
    taps /= taps.sum()
    for n in range(places.shape[0]):
        corner = np.rint(places[n, 0]) - size // 2, np.rint(places[n, 1]) - size // 2
        votes = np.zeros((size, size))
        count_near(edges, places[n, 2], corner, votes)
        smooth = blurred(votes, taps)
        best_r, best_c = HALF_PEAK, HALF_PEAK
        for r in range(HALF_PEAK, smooth.shape[0] - HALF_PEAK):
            for c in range(HALF_PEAK, smooth.shape[1] - HALF_PEAK):
                if smooth[r, c] > smooth[best_r, best_c]:
                    best_r, best_c = r, c
        total, down, across = 0.0, 0.0, 0.0
        for r in range(best_r - HALF_PEAK, best_r + HALF_PEAK + 1):
            for c in range(best_c - HALF_PEAK, best_c + HALF_PEAK + 1):
                total += smooth[r, c]
                down += smooth[r, c] * r
                across += smooth[r, c] * c
        total = max(total, NO_VOTES)
        peaks[n, 0] = corner[0] + HALF_BLUR + down / total
        peaks[n, 1] = corner[1] + HALF_BLUR + across / total
        peaks[n, 2] = smooth[best_r, best_c] * BLUR_PX**2 / places[n, 2]
    return peaks


@part
def count_near(edges: Edges, radius_px: float, corner: tuple[float, float], votes: Floats) -> None:
    """Count the votes for discs of a radius centred on each pixel of a square."""
    row, column, normal_row, normal_column = edges
    for k in range(row.size):
        for side in (-radius_px, radius_px):
            r = int(np.rint(row[k] + side * normal_row[k] - corner[0]))
            c = int(np.rint(column[k] + side * normal_column[k] - corner[1]))
            if 0 <= r < votes.shape[0] and 0 <= c < votes.shape[1]:
                votes[r, c] += 1.0


@part
def blurred(votes: Floats, taps: Floats) -> Floats:
    """Return votes smoothed along both axes, smaller by the taps' reach on each side."""
    size = votes.shape[0] - taps.size + 1
    across, smooth = np.zeros((votes.shape[0], size)), np.zeros((size, size))
    for r in range(votes.shape[0]):
        for i in range(taps.size):
            for c in range(size):
                across[r, c] += taps[i] * votes[r, c + i]
    for r in range(size):
        for i in range(taps.size):
            for c in range(size):
                smooth[r, c] += taps[i] * across[r + i, c]
    return smooth


def _peak(votes: NDArray[np.float32], r: int, c: int) -> Disc:
    half = HALF_PEAK
    window = votes[max(r - half, 0) : r + half + 1, max(c - half, 0) : c + half + 1]
    weight = float(window.sum()) or 1.0
    rows = np.arange(max(r - half, 0), max(r - half, 0) + window.shape[0])
    columns = np.arange(max(c - half, 0), max(c - half, 0) + window.shape[1])
    return Disc(
        row=float((window.sum(axis=1) * rows).sum() / weight) - PADDING_PX,
        column=float((window.sum(axis=0) * columns).sum() / weight) - PADDING_PX,
        rim_share=float(votes[r, c]),
    )


def common_radius(
    points: EdgePoints,
    shape: tuple[int, int],
    range_px: tuple[float, float],
    sizes: Mapping[float, int],
) -> float:
    """Return the radius of size 1 at which discs of some sizes stand out from all other places.

    Markers and highlights vote for many small discs, each as full as the next one. So the shares
    of the rims of the best places count less those of the next as many. Tried in steps of 2 per
    cent; good to about a pixel.

    Parameters
    ----------
    range_px
        Of the radius of the smallest disc, and of the largest.
    sizes
        How many discs there are of each size: two alike are {1.0: 2}, a second one half as large
        makes it {1.0: 1, 0.5: 1}.
    """
    smallest, largest = range_px[0] / min(sizes), range_px[1] / max(sizes)
    steps = int(np.ceil(np.log(largest / smallest) / 0.02)) + 1
    radii = np.geomspace(smallest, largest, steps)
    scores = []
    for radius in radii:
        score = 0.0
        for size, count in sizes.items():
            votes = vote(points, float(size * radius), shape)
            peaks = summits(votes, 0.1, int(size * radius))
            shares = np.sort(votes[peaks[:, 0], peaks[:, 1]])[::-1]
            best, next_best = shares[:count], shares[count : 2 * count]
            score += float(best.sum(dtype=np.float64) - next_best.sum(dtype=np.float64))
        scores.append(score)
    return float(radii[int(np.argmax(scores))])
