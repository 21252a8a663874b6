"""Discs of a known radius in a frame: every strong gradient votes for the centre it points to."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey
from analysis.compiled import compiled

Single = NDArray[np.float32]

SMOOTH_PX = 1.2
GATHER_PX = 1.3
BEYOND_NOISE = 6.0
SPREAD_PX = 0.7
LEAST_SHARE = 0.25
"""Of the votes that a whole, evenly lit outline would give."""


@compiled
def cast(rows: Single, columns: Single, least: float, radius: float, votes: Single) -> None:
    """Add the votes of every pixel whose gradient exceeds `least`.

    Parameters
    ----------
    rows, columns
        Gradient of the frame less background, grey levels a pixel, shape (rows, columns).
    votes
        Added to, same shape.
    """
    for i in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            d_r, d_c = rows[i, j], columns[i, j]
            size = math.sqrt(d_r * d_r + d_c * d_c)
            if size < least:
                continue
            for k in range(-1, 2):
                reach = (radius + SPREAD_PX * k) / size
                y, x = int(np.rint(i + reach * d_r)), int(np.rint(j + reach * d_c))
                if 0 <= y < votes.shape[0] and 0 <= x < votes.shape[1]:
                    votes[y, x] += 1.0


def vote_map(frame: Grey, background: Floats, noise: float, radius: float) -> Single:
    """Return the votes for a disc's centre at each pixel as a share of a whole outline's."""
    off = np.abs(frame.astype(np.float32) - background.astype(np.float32))
    smooth = cv2.GaussianBlur(off, (0, 0), SMOOTH_PX)
    # Sobel's weights sum to 8 grey levels for a slope of one a pixel.
    rows: Single = np.asarray(cv2.Sobel(smooth, cv2.CV_32F, 0, 1) / 8.0, dtype=np.float32)
    columns: Single = np.asarray(cv2.Sobel(smooth, cv2.CV_32F, 1, 0) / 8.0, dtype=np.float32)
    noise_slope = noise / (math.sqrt(8 * math.pi) * SMOOTH_PX**2)
    votes = np.zeros(off.shape, dtype=np.float32)
    cast(rows, columns, BEYOND_NOISE * noise_slope, radius, votes)
    gathered = cv2.GaussianBlur(votes, (0, 0), GATHER_PX)
    whole = 3 * 2 * math.pi * radius * 3 * SMOOTH_PX / (2 * math.pi * GATHER_PX**2 * 3)
    return np.asarray(gathered / whole, dtype=np.float32)


def peak_near(votes: Single, place: tuple[float, float], reach: float) -> tuple[float, float]:
    """Return the best supported place within `reach` pixels, to a fraction of a pixel.

    The place itself comes back where nothing near it has votes.
    """
    rows, columns = votes.shape
    top, left = max(int(place[0] - reach), 0), max(int(place[1] - reach), 0)
    part = votes[top : int(place[0] + reach) + 2, left : int(place[1] + reach) + 2]
    if part.size == 0 or part.max() < LEAST_SHARE:
        return place
    i, j = np.unravel_index(int(part.argmax()), part.shape)
    return _vertex(
        votes, min(max(int(i) + top, 1), rows - 2), min(max(int(j) + left, 1), columns - 2)
    )


def _vertex(votes: Single, i: int, j: int) -> tuple[float, float]:
    """Return the vertex of parabolas through a maximum and its neighbours."""
    along = votes[i - 1 : i + 2, j].astype(np.float64)
    across = votes[i, j - 1 : j + 2].astype(np.float64)
    off = []
    for low, middle, high in (along, across):
        bend = low - 2 * middle + high
        off.append(float(np.clip(0.5 * (low - high) / bend, -1, 1)) if bend < 0 else 0.0)
    return i + off[0], j + off[1]


def peaks(votes: Single, count: int, apart: float) -> list[tuple[float, float, float]]:
    """Return the `count` best supported places at least `apart` pixels from each other.

    Each with row, column and share; fewer where fewer have votes.
    """
    left = votes.copy()
    found: list[tuple[float, float, float]] = []
    for _ in range(count):
        i, j = map(int, np.unravel_index(int(left.argmax()), left.shape))
        share = float(left[i, j])
        if share < LEAST_SHARE:
            break
        inner = 0 < i < votes.shape[0] - 1 and 0 < j < votes.shape[1] - 1
        row, column = _vertex(votes, i, j) if inner else (float(i), float(j))
        found.append((row, column, share))
        y, x = np.ogrid[: left.shape[0], : left.shape[1]]
        left[(y - i) ** 2 + (x - j) ** 2 < apart**2] = 0.0
    return found
