"""Laplacian of Gaussian: the filter whose zeros are the edges (thesis, section 4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

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
    image = np.asarray(frame, dtype=np.float32)
    smooth, first, second = gaussian_kernels(sigma_px)

    def separable(
        along_row: NDArray[np.float64], along_column: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        filtered = cv2.sepFilter2D(
            image, cv2.CV_32F, along_column, along_row, borderType=cv2.BORDER_REPLICATE
        )
        return np.asarray(filtered, dtype=np.float32)

    return EdgeImage(
        log=separable(second, smooth) + separable(smooth, second),
        gradient_row=separable(first, smooth),
        gradient_column=separable(smooth, first),
        sigma_px=sigma_px,
    )
