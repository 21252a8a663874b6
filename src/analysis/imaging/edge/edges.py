"""Laplacian of Gaussian: the filter whose zeros are the edges (thesis, section 4.1)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey, Singles
from analysis.compiled import compiled, part

HALF_WIDTH_PER_SIGMA = 4
"""The thesis cuts the filter at 17 x 17 pixels for a standard deviation of 2: four each side."""
ROWS_AT_ONCE, STRIP, PAIRS = 8, 80, 6
"""Rows filtered as one line; columns of a strip, margins among them; pairs of mirrored taps summed
at once, as many as a filter of 1.2 to 1.5 pixels has. Filters of up to 8 pixels leave a few columns
of a strip between its margins."""
LANE = ROWS_AT_ONCE * STRIP
SLOPE, BEND = np.uint64(LANE), np.uint64(2 * LANE)
"""Where the lanes of first and second derivatives begin. Lanes of one array follow each other, so
that the compiler knows that they are apart."""


@dataclass(frozen=True, slots=True, eq=False)
class EdgeImage:
    """A frame filtered for edges.

    Attributes
    ----------
    log
        Laplacian of the Gaussian-smoothed frame, grey levels per pixel squared, shape (rows,
        columns). Positive on the dark side of an edge.
    gradient_row, gradient_column
        Gradient of the smoothed frame, grey levels per pixel, same shape; points to the bright
        side.
    sigma_px
        Standard deviation of the Gaussian.
    """

    log: NDArray[np.float32]
    gradient_row: NDArray[np.float32]
    gradient_column: NDArray[np.float32]
    sigma_px: float


def gaussian_kernels(
    sigma_px: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the sampled Gaussian and its first and second derivative, each of 8 sigma + 1 taps.

    The second derivative sums to zero, so that a flat frame gives exactly zero, and has the
    second moment 2, so that a parabola gives its true curvature.
    """
    half = round(HALF_WIDTH_PER_SIGMA * sigma_px)
    x = np.arange(-half, half + 1, dtype=np.float64)
    smooth = np.exp(-0.5 * (x / sigma_px) ** 2)
    smooth /= smooth.sum()
    first = x * smooth
    first /= (x * first).sum()
    second = (x**2 / sigma_px**4 - 1 / sigma_px**2) * smooth
    second -= smooth * second.sum()
    second *= 2.0 / (x**2 * second).sum()
    return smooth, first, second


def laplacian_of_gaussian(frame: Grey | Floats, sigma_px: float = 2.0) -> EdgeImage:
    """Filter a frame with the Laplacian of a Gaussian, and keep the gradient beside it.

    Parameters
    ----------
    frame
        Grey levels, shape (rows, columns).
    sigma_px
        Standard deviation of the Gaussian; the thesis uses 2, on 17 x 17 pixels.

    Notes
    -----
    Separable form of equation (2) of D. Marr and E. Hildreth, "Theory of edge detection",
    Proc. R. Soc. Lond. B 207, 187-217 (1980), doi:10.1098/rspb.1980.0020. The frame is continued
    by its edge pixels.
    """
    image = np.ascontiguousarray(frame, dtype=np.float32)
    log, down, across = (np.empty_like(image) for _ in range(3))
    filter_whole(image, half_kernels(sigma_px), (log, down, across))
    return EdgeImage(log, down, across, sigma_px)


@cache
def half_kernels(sigma_px: float) -> Singles:
    """Return the middle and later taps of `gaussian_kernels`, filled up with zeros.

    Returns
    -------
    Shape (3, 1 + a multiple of PAIRS).

    Raises
    ------
    ValueError
        The filter is so wide that nothing is left of a strip between its margins.
    """
    kernels = np.array(gaussian_kernels(sigma_px))
    later = kernels[:, kernels.shape[1] // 2 :]
    taps = np.pad(later, ((0, 0), (0, (1 - later.shape[1]) % PAIRS))).astype(np.float32)
    if 2 * taps.shape[1] >= STRIP:
        raise ValueError(f"an edge filter of {sigma_px:g} pixels; at most 8 are possible")
    return taps


@compiled
def filter_whole(image: Singles, taps: Singles, edges: tuple[Singles, Singles, Singles]) -> None:
    """Filter a picture; its edge pixels go on outside.

    Parameters
    ----------
    taps
        `half_kernels`.
    edges
        Filled with the fields of `EdgeImage`, each of the picture's shape.
    """
    reach, (rows, columns) = taps.shape[1] - 1, image.shape
    for left in range(0, columns, STRIP - 2 * reach):
        framed = framed_strip(image, (-reach, left - reach), rows + 2 * reach)
        log = np.empty((rows, STRIP), dtype=np.float32)
        filtered = log, np.empty_like(log), np.empty_like(log)
        filter_strip(framed, taps, filtered)
        wide = min(STRIP - 2 * reach, columns - left)
        for n in range(3):
            edges[n][:, left : left + wide] = filtered[n][:, reach : reach + wide]


@part
def framed_strip(frame: NDArray[Any], corner: tuple[int, int], height: int) -> Singles:
    """Return rows of a frame, STRIP columns wide, that begin at a corner; edge pixels go on."""
    rows, columns = frame.shape
    top, left = corner
    framed = np.empty((height, STRIP), dtype=np.float32)
    before = min(max(-left, 0), STRIP)
    until = max(min(columns - left, STRIP), before)
    for r in range(height):
        own, whole = framed[r], frame[min(max(top + r, 0), rows - 1)]
        inside, own_inside = whole[left + before : left + until], own[before:until]
        for c in range(inside.size):
            own_inside[c] = inside[c]
        own[:before] = whole[0]
        own[until:] = whole[columns - 1]
    return framed


@part
def filter_strip(framed: Singles, taps: Singles, edges: tuple[Singles, Singles, Singles]) -> None:
    """Filter a strip of a picture; sums and differences of mirrored pixels serve all kernels.

    Several rows are filtered as one line: vector instructions like long ones. What that makes of
    the margins left and right means nothing.

    Parameters
    ----------
    framed
        Grey levels with as many more on each side as a kernel reaches, STRIP columns wide.
    taps
        `half_kernels`.
    edges
        Filled with the fields of `EdgeImage`, still with the margins left and right.
    """
    reach, size = taps.shape[1] - 1, edges[0].size
    picture, log = framed.ravel(), edges[0].ravel()
    down, across = edges[1].ravel(), edges[2].ravel()
    lines = np.empty(3 * LANE + 2 * reach, dtype=np.float32)
    for first in range(0, size, LANE):
        few, inner = min(LANE, size - first), first + reach
        along_columns(picture[first:], taps, few, lines)
        along_rows(lines, taps, few - 2 * reach, (log[inner:], down[inner:], across[inner:]))


@part
def along_columns(picture: Singles, taps: Singles, size: int, lines: Singles) -> None:
    """Filter some rows along columns.

    Parameters
    ----------
    lines
        Filled with the rows smoothed, differentiated once and differentiated twice, in lanes.
    """
    reach = taps.shape[1] - 1
    middle = picture[reach * STRIP :]
    for k in range(np.uint64(size)):
        lines[k], lines[k + SLOPE] = taps[0, 0] * middle[k], 0.0
        lines[k + BEND] = taps[2, 0] * middle[k]
    for first in range(0, reach, PAIRS):
        above, below = picture[(reach - first - PAIRS) * STRIP :], middle[first * STRIP :]
        few = taps[:, first : first + PAIRS + 1].copy()
        # The number of pairs and their distances are known to the compiler: sums stay at hand.
        for k in range(np.uint64(size)):
            smooth, slope, bend = lines[k], lines[k + SLOPE], lines[k + BEND]
            for i in range(1, PAIRS + 1):
                upper = above[k + np.uint64((PAIRS - i) * STRIP)]
                lower = below[k + np.uint64(i * STRIP)]
                smooth += few[0, i] * (upper + lower)
                bend += few[2, i] * (upper + lower)
                slope += few[1, i] * (lower - upper)
            lines[k], lines[k + SLOPE], lines[k + BEND] = smooth, slope, bend


@part
def along_rows(
    lines: Singles, taps: Singles, size: int, edges: tuple[Singles, Singles, Singles]
) -> None:
    """Filter rows that were filtered along columns, all but their ends."""
    log, down, across = edges
    reach = taps.shape[1] - 1
    middle = lines[reach:]
    for k in range(np.uint64(size)):
        log[k] = taps[0, 0] * middle[k + BEND] + taps[2, 0] * middle[k]
        down[k], across[k] = taps[0, 0] * middle[k + SLOPE], 0.0
    for first in range(0, reach, PAIRS):
        before, after = lines[reach - first - PAIRS :], middle[first:]
        few = taps[:, first : first + PAIRS + 1].copy()
        for k in range(np.uint64(size)):
            laplacian, row, column = log[k], down[k], across[k]
            for i in range(1, PAIRS + 1):
                p, q = k + np.uint64(PAIRS - i), k + np.uint64(i)
                laplacian += few[0, i] * (before[p + BEND] + after[q + BEND])
                laplacian += few[2, i] * (before[p] + after[q])
                row += few[0, i] * (before[p + SLOPE] + after[q + SLOPE])
                column += few[1, i] * (after[q] - before[p])
            log[k], down[k], across[k] = laplacian, row, column
