"""Edges by the gradient instead of the Laplacian: Sobel and Canny, to compare (thesis, 2.2.1).

Both thin the gradient to its ridges. Their edge points lie at pixel centres.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey
from analysis.imaging.edge.edges import gaussian_kernels
from analysis.imaging.edge.facet import EdgePoints

Frame = Grey | Floats

SOBEL_SMOOTH, SOBEL_SLOPE = np.array([0.25, 0.5, 0.25]), np.array([-0.5, 0.0, 0.5])
"""Scaled so that a slope of one grey level a pixel gives 1."""
CANNY_SIGMA_PX = 1.0
LOW_SHARE = 0.4
"""Canny's lower threshold as a share of the upper; he asks for a half to a third."""


def sobel_edges(frame: Frame, least_strength: float) -> EdgePoints:
    """Find edges as ridges of the Sobel gradient.

    Parameters
    ----------
    frame
        Grey levels, shape (rows, columns).
    least_strength
        Gradient below which a ridge is taken for noise, grey levels per pixel.
    """
    g_r, g_c = _gradient(frame, SOBEL_SLOPE, SOBEL_SMOOTH)
    return _points(ridges(g_r, g_c) & (np.hypot(g_r, g_c) >= least_strength), g_r, g_c)


def canny_edges(
    frame: Frame, least_strength: float, sigma_px: float = CANNY_SIGMA_PX
) -> EdgePoints:
    """Find edges as ridges of the smoothed gradient, followed with two thresholds.

    J. Canny, "A computational approach to edge detection", IEEE Trans. PAMI 8, 679-698 (1986),
    doi:10.1109/TPAMI.1986.4767851. A ridge counts where it is connected to a part that reaches
    `least_strength` and nowhere falls below LOW_SHARE of it.

    Parameters
    ----------
    least_strength
        Upper threshold, grey levels per pixel.
    sigma_px
        Standard deviation of the Gaussian.
    """
    smooth, first, _ = gaussian_kernels(sigma_px)
    g_r, g_c = _gradient(frame, first, smooth)
    strength = np.hypot(g_r, g_c)
    weak = ridges(g_r, g_c) & (strength >= LOW_SHARE * least_strength)
    _, curves = cv2.connectedComponents(weak.astype(np.uint8), connectivity=8)
    held = np.unique(curves[weak & (strength >= least_strength)])
    return _points(weak & np.isin(curves, held), g_r, g_c)


def ridges(gradient_row: Floats, gradient_column: Floats) -> NDArray[np.bool_]:
    """Mark pixels whose gradient is not exceeded by its neighbours across the edge.

    The neighbours one step along the gradient and against it are interpolated between the two
    pixels they fall between. The frame's border is never marked.

    Parameters
    ----------
    gradient_row, gradient_column
        Shape (rows, columns).
    """
    strength = np.hypot(gradient_row, gradient_column)
    steep = np.maximum(np.abs(gradient_row), np.abs(gradient_column))
    step_r = np.divide(gradient_row, steep, out=np.zeros_like(strength), where=steep > 0)
    step_c = np.divide(gradient_column, steep, out=np.zeros_like(strength), where=steep > 0)
    rows, columns = np.indices(strength.shape).astype(np.float64)

    def beyond(sign: float) -> Floats:
        at_r, at_c = rows + sign * step_r, columns + sign * step_c
        seen = cv2.remap(
            strength, at_c.astype(np.float32), at_r.astype(np.float32), cv2.INTER_LINEAR
        )
        return np.asarray(seen, dtype=np.float64)

    # Of two equal neighbours only one may stand.
    marked = (strength > beyond(1.0)) & (strength >= beyond(-1.0))
    inside = np.zeros_like(marked)
    inside[1:-1, 1:-1] = True
    return np.asarray(marked & inside)


def _gradient(frame: Frame, slope: Floats, smooth: Floats) -> tuple[Floats, Floats]:
    """Return the gradient along rows and columns, grey levels per pixel."""
    image = np.asarray(frame, dtype=np.float64)
    border = cv2.BORDER_REPLICATE
    along = cv2.sepFilter2D(image, cv2.CV_64F, smooth, slope, borderType=border)
    across = cv2.sepFilter2D(image, cv2.CV_64F, slope, smooth, borderType=border)
    return np.asarray(along), np.asarray(across)


def _points(marked: NDArray[np.bool_], g_r: Floats, g_c: Floats) -> EdgePoints:
    rows, columns = np.nonzero(marked)
    own_r, own_c = g_r[rows, columns], g_c[rows, columns]
    strength = np.hypot(own_r, own_c)
    return EdgePoints(
        row=rows.astype(np.float64),
        column=columns.astype(np.float64),
        normal_row=own_r / strength,
        normal_column=own_c / strength,
        strength=strength,
        pixel_row=rows,
        pixel_column=columns,
    )
