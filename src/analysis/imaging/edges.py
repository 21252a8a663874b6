"""Laplacian of Gaussian: the filter whose zeros are the edges (thesis, section 4.1)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part

Singles = NDArray[np.float32]

HALF_WIDTH_PER_SIGMA = 4
"""The thesis cuts the filter at 17 x 17 pixels for a standard deviation of 2: four each side."""
ROWS_AT_ONCE = 8


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


def laplacian_of_gaussian(
    frame: NDArray[np.uint8] | NDArray[np.float64], sigma_px: float = 2.0
) -> EdgeImage:
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
    taps = half_kernels(sigma_px)
    image = np.ascontiguousarray(frame, dtype=np.float32)
    framed = np.pad(image, taps.shape[1] - 1, mode="edge")
    filtered = np.empty((3, frame.shape[0], framed.shape[1]), dtype=np.float32)
    filter_whole(framed, taps, (filtered[0], filtered[1], filtered[2]))
    inner = slice(taps.shape[1] - 1, 1 - taps.shape[1])
    log, down, across = np.ascontiguousarray(filtered[:, :, inner])
    return EdgeImage(log, down, across, sigma_px)


@cache
def half_kernels(sigma_px: float) -> Singles:
    """Return the middle and later taps of `gaussian_kernels`, an even number of later ones.

    Returns
    -------
    Shape (3, 4 sigma + 1), where 4 sigma is odd one more, which is 0.
    """
    kernels = np.array(gaussian_kernels(sigma_px))
    later = kernels[:, kernels.shape[1] // 2 :]
    return np.pad(later, ((0, 0), (0, (later.shape[1] + 1) % 2))).astype(np.float32)


@compiled
def filter_whole(framed: Singles, taps: Singles, edges: tuple[Singles, Singles, Singles]) -> None:
    """Filter as `filter_framed` does, on its own."""
    filter_framed(framed, taps, edges)


@part
def filter_framed(framed: Singles, taps: Singles, edges: tuple[Singles, Singles, Singles]) -> None:
    """Filter a picture; sums and differences of mirrored pixels serve all kernels.

    Several rows are filtered as one line: vector instructions like long ones. What that makes of
    the margins left and right means nothing.

    Parameters
    ----------
    framed
        Grey levels with as many more on each side as a kernel reaches.
    taps
        `half_kernels`.
    edges
        Filled with the fields of `EdgeImage`, still with the margins left and right.
    """
    reach, (rows, wide) = taps.shape[1] - 1, edges[0].shape
    picture, log, down, across = (
        framed.ravel(),
        edges[0].ravel(),
        edges[1].ravel(),
        edges[2].ravel(),
    )
    smooth = np.empty(ROWS_AT_ONCE * wide, dtype=np.float32)
    slope, bend = np.empty_like(smooth), np.empty_like(smooth)
    for first in range(0, rows * wide, smooth.size):
        size = min(smooth.size, rows * wide - first)
        middle = picture[first + reach * wide :]
        for k in range(size):
            smooth[k], bend[k], slope[k] = taps[0, 0] * middle[k], taps[2, 0] * middle[k], 0.0
        # Two taps at a time: half as often are the sums fetched and put back.
        for i in range(1, reach, 2):
            upper, lower = (
                picture[first + (reach - i) * wide :],
                picture[first + (reach + i) * wide :],
            )
            above = picture[first + (reach - i - 1) * wide :]
            below = picture[first + (reach + i + 1) * wide :]
            t_0, t_1, t_2 = taps[0, i], taps[1, i], taps[2, i]
            f_0, f_1, f_2 = taps[0, i + 1], taps[1, i + 1], taps[2, i + 1]
            for k in range(size):
                near, far = upper[k] + lower[k], above[k] + below[k]
                smooth[k] += t_0 * near + f_0 * far
                bend[k] += t_2 * near + f_2 * far
                slope[k] += t_1 * (lower[k] - upper[k]) + f_1 * (below[k] - above[k])
        inner = first + reach
        filter_across((smooth[:size], slope[:size], bend[:size]), taps, log[inner:])
        along_columns((smooth[:size], slope[:size]), taps, down[inner:], across[inner:])


@part
def filter_across(lines: tuple[Singles, Singles, Singles], taps: Singles, log: Singles) -> None:
    """Filter rows that were filtered along columns; the Laplacian of all but their ends."""
    smooth, _, bend = lines
    reach = taps.shape[1] - 1
    s, b, size = smooth[reach:], bend[reach:], smooth.size - 2 * reach
    for k in range(size):
        log[k] = taps[0, 0] * b[k] + taps[2, 0] * s[k]
    for i in range(1, reach, 2):
        t_0, t_2, f_0, f_2 = taps[0, i], taps[2, i], taps[0, i + 1], taps[2, i + 1]
        s_0, s_1, s_2, s_3 = _beside(smooth, reach, i)
        b_0, b_1, b_2, b_3 = _beside(bend, reach, i)
        for k in range(size):
            near = t_0 * (b_0[k] + b_1[k]) + t_2 * (s_0[k] + s_1[k])
            log[k] += near + f_0 * (b_2[k] + b_3[k]) + f_2 * (s_2[k] + s_3[k])


@part
def along_columns(
    lines: tuple[Singles, Singles], taps: Singles, down: Singles, across: Singles
) -> None:
    """Filter rows that were filtered along columns; the gradient of all but their ends."""
    smooth, slope = lines
    reach = taps.shape[1] - 1
    d, size = slope[reach:], smooth.size - 2 * reach
    for k in range(size):
        down[k], across[k] = taps[0, 0] * d[k], 0.0
    for i in range(1, reach, 2):
        t_0, t_1, f_0, f_1 = taps[0, i], taps[1, i], taps[0, i + 1], taps[1, i + 1]
        s_0, s_1, s_2, s_3 = _beside(smooth, reach, i)
        d_0, d_1, d_2, d_3 = _beside(slope, reach, i)
        for k in range(size):
            down[k] += t_0 * (d_0[k] + d_1[k]) + f_0 * (d_2[k] + d_3[k])
            across[k] += t_1 * (s_1[k] - s_0[k]) + f_1 * (s_3[k] - s_2[k])


@part
def _beside(line: Singles, reach: int, i: int) -> tuple[Singles, Singles, Singles, Singles]:
    """Return a line moved by i to the left and to the right, and by one more."""
    return line[reach - i :], line[reach + i :], line[reach - i - 1 :], line[reach + i + 1 :]
