"""The filtered frame made n times finer, and its zero crossings there (thesis, section 4.2).

The programs pix2sub_3 and pix2sub_4 of the thesis (appendix C) do this with n = 3 and 4. An edge
point then lies on a grid of 1/n pixel; `facet.edge_points` takes the exact root instead.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.imaging.edge.edges import EdgeImage
from analysis.imaging.edge.facet import (
    EdgePoints,
    beside_change_of_sign,
    facet_coefficients,
    neighbourhoods,
    zero_crossing_pixels,
)


def sample_offsets(samples_per_pixel: int) -> Floats:
    """Return where the n samples of a pixel lie along one axis, pixels from its centre.

    They are the centres of n equal parts, so the expanded frame is a regular grid.

    Raises
    ------
    ValueError
        Fewer than one sample.
    """
    if samples_per_pixel < 1:
        raise ValueError(f"{samples_per_pixel} samples a pixel, at least 1 is needed")
    return (np.arange(samples_per_pixel) + 0.5) / samples_per_pixel - 0.5


def expand(values: NDArray[np.floating], samples_per_pixel: int) -> Floats:
    """Sample the facet of every pixel at n x n points.

    Parameters
    ----------
    values
        Filtered frame, shape (rows, columns); its border is continued outwards.
    samples_per_pixel
        The thesis has 3 or 4.

    Returns
    -------
    Shape (n rows, n columns). Element (i, j) lies at pixel (i + 0.5) / n - 0.5 in rows, likewise
    in columns.
    """
    n = samples_per_pixel
    rows, columns = np.indices(values.shape).reshape(2, -1)
    framed = np.pad(values, 1, mode="edge")
    fine = _sampled(neighbourhoods(framed, rows + 1, columns + 1), n)
    whole = fine.reshape(*values.shape, n, n).transpose(0, 2, 1, 3)
    return np.asarray(whole.reshape(n * values.shape[0], n * values.shape[1]))


def expanded_zero_crossings(
    edges: EdgeImage, least_strength: float, samples_per_pixel: int
) -> EdgePoints:
    """Find the edge points of a frame on the grid of its expansion, as the thesis does.

    Each pixel beside a change of sign is expanded with its neighbours' facets, and the samples
    beside a change of sign, on the side nearer to zero, are the points. Only those pixels need
    to be expanded.

    Parameters
    ----------
    least_strength
        Gradient below which a crossing is taken for noise, grey levels per pixel.
    samples_per_pixel
        The thesis has 3 or 4.
    """
    marked = zero_crossing_pixels(edges, least_strength)
    corner, box = _around(marked)
    fine = expand(edges.log[box], samples_per_pixel)
    own = np.kron(marked[box], np.ones((samples_per_pixel,) * 2, dtype=np.bool_))
    at = np.argwhere(beside_change_of_sign(fine) & own) + samples_per_pixel * corner
    pixel = at // samples_per_pixel
    place = (at + 0.5) / samples_per_pixel - 0.5
    g_r = edges.gradient_row[pixel[:, 0], pixel[:, 1]].astype(np.float64)
    g_c = edges.gradient_column[pixel[:, 0], pixel[:, 1]].astype(np.float64)
    strength = np.hypot(g_r, g_c)
    return EdgePoints(
        row=place[:, 0],
        column=place[:, 1],
        normal_row=g_r / strength,
        normal_column=g_c / strength,
        strength=strength,
        pixel_row=pixel[:, 0],
        pixel_column=pixel[:, 1],
    )


def _around(marked: NDArray[np.bool_]) -> tuple[NDArray[np.intp], tuple[slice, slice]]:
    """Return the first row and column of the part that holds all marks and their neighbours."""
    at = np.argwhere(marked) if marked.any() else np.zeros((1, 2), dtype=np.intp)
    low, high = np.maximum(at.min(axis=0) - 1, 0), at.max(axis=0) + 2
    return low, (slice(low[0], high[0]), slice(low[1], high[1]))


def _sampled(patches: Floats, samples_per_pixel: int) -> Floats:
    """Return the facets' values at the samples of their middle pixels, shape (points, n, n)."""
    t = sample_offsets(samples_per_pixel)
    basis = np.stack([np.ones_like(t), t, t**2 - 2 / 3])
    return np.asarray(np.einsum("ia,pij,jb->pab", basis, facet_coefficients(patches), basis))
