"""Laplacian of Gaussian: the filter whose zeros are the edges (thesis, section 4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part

Singles = NDArray[np.float32]

HALF_WIDTH_PER_SIGMA = 4
"""The thesis cuts the filter at 17 x 17 pixels for a standard deviation of 2: four each side."""


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
    log, down, across = np.empty((3, *frame.shape), dtype=np.float32)
    filter_whole(framed, taps, (log, down, across))
    return EdgeImage(log, down, across, sigma_px)


def half_kernels(sigma_px: float) -> Singles:
    """Return the middle and later taps of `gaussian_kernels`, shape (3, 4 sigma + 1)."""
    kernels = np.array(gaussian_kernels(sigma_px))
    return np.ascontiguousarray(kernels[:, kernels.shape[1] // 2 :], dtype=np.float32)


@compiled
def filter_whole(framed: Singles, taps: Singles, edges: tuple[Singles, Singles, Singles]) -> None:
    """Filter as `filter_framed` does, on its own."""
    filter_framed(framed, taps, edges)


@part
def filter_framed(framed: Singles, taps: Singles, edges: tuple[Singles, Singles, Singles]) -> None:
    """Filter a picture row by row; sums and differences of mirrored pixels serve all kernels.

    Parameters
    ----------
    framed
        Grey levels with as many more on each side as a kernel reaches.
    taps
        `half_kernels`.
    edges
        Filled with the fields of `EdgeImage`.
    """
    log, down, across = edges
    reach, (rows, columns) = taps.shape[1] - 1, log.shape
    wide = columns + 2 * reach
    smooth, slope, bend = (
        np.empty(wide, dtype=np.float32),
        np.empty(wide, dtype=np.float32),
        np.empty(wide, dtype=np.float32),
    )
    for r in range(rows):
        middle = framed[r + reach]
        for c in range(wide):
            smooth[c], bend[c], slope[c] = taps[0, 0] * middle[c], taps[2, 0] * middle[c], 0.0
        for i in range(1, reach + 1):
            upper, lower = framed[r + reach - i], framed[r + reach + i]
            t_0, t_1, t_2 = taps[0, i], taps[1, i], taps[2, i]
            for c in range(wide):
                both = upper[c] + lower[c]
                smooth[c] += t_0 * both
                bend[c] += t_2 * both
                slope[c] += t_1 * (lower[c] - upper[c])
        own_log, own_down, own_across = log[r], down[r], across[r]
        s, d, b = smooth[reach:], slope[reach:], bend[reach:]
        for c in range(columns):
            own_log[c] = taps[0, 0] * b[c] + taps[2, 0] * s[c]
            own_down[c], own_across[c] = taps[0, 0] * d[c], 0.0
        for i in range(1, reach + 1):
            t_0, t_1, t_2 = taps[0, i], taps[1, i], taps[2, i]
            s_0, s_1 = smooth[reach - i :], smooth[reach + i :]
            d_0, d_1 = slope[reach - i :], slope[reach + i :]
            b_0, b_1 = bend[reach - i :], bend[reach + i :]
            for c in range(columns):
                own_log[c] += t_0 * (b_0[c] + b_1[c]) + t_2 * (s_0[c] + s_1[c])
                own_down[c] += t_0 * (d_0[c] + d_1[c])
                own_across[c] += t_1 * (s_1[c] - s_0[c])
