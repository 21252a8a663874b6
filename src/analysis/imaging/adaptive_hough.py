"""The adaptive Hough transform for one circle, to compare (thesis, sections 2.2.2 and 4.4).

J. Illingworth and J. Kittler, "The adaptive Hough transform", IEEE Trans. PAMI 9, 690-698 (1987),
doi:10.1109/TPAMI.1987.4767964. A small accumulator is laid over the centre's range, its fullest
part becomes the next range, and so on until a cell is small enough: first for the centre, which
lies on every edge point's normal, then for the radius.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from analysis.arrays import Floats
from analysis.imaging.edge.facet import EdgePoints
from analysis.imaging.outlines import Place

Range = tuple[float, float]

CELLS = 9
"""Cells along each side of the accumulator, as in the paper."""
FULL_SHARE = 0.9
"""A cell with this share of the most votes is part of the peak."""
MOST_ROUNDS = 40


def adaptive_hough(
    points: EdgePoints,
    rows: Range,
    columns: Range,
    radii: Range,
    *,
    cell_px: float = 0.1,
) -> Place | None:
    """Find the circle that most edge points vote for.

    Parameters
    ----------
    points
        Edge points of a frame; their normals are used.
    rows, columns, radii
        Ranges, pixels, in which centre and radius are sought.
    cell_px
        Size at which a cell is small enough.

    Returns
    -------
    Row, column and radius, pixels; None where no point votes for any centre in range.
    """
    centre = _centre(points, rows, columns, cell_px)
    if centre is None:
        return None
    distances = np.hypot(points.row - centre[0], points.column - centre[1])
    radius = _radius(distances, radii, cell_px)
    return None if radius is None else (*centre, radius)


def _centre(
    points: EdgePoints, rows: Range, columns: Range, cell_px: float
) -> tuple[float, float] | None:
    ranges = np.array([rows, columns], dtype=np.float64)
    for _ in range(MOST_ROUNDS):
        cell = np.diff(ranges, axis=1)[:, 0] / CELLS
        if cell.max() <= cell_px:
            break
        votes = centre_votes(points, ranges)
        if votes.max() == 0:
            return None
        ranges = _peak_range(votes, ranges)
    return float(ranges[0].mean()), float(ranges[1].mean())


def centre_votes(points: EdgePoints, ranges: Floats) -> NDArray[np.intp]:
    """Count for each cell the edge points whose normal, as a line, passes through it.

    Parameters
    ----------
    ranges
        Lower and upper end of rows and of columns, pixels, shape (2, 2).

    Returns
    -------
    Shape (CELLS, CELLS).
    """
    cell = np.diff(ranges, axis=1)[:, 0] / CELLS
    at = ranges[:, :1] + (np.arange(CELLS) + 0.5) * cell[:, None]
    d_r = at[0][:, None, None] - points.row
    d_c = at[1][None, :, None] - points.column
    off_line = np.abs(d_r * points.normal_column - d_c * points.normal_row)
    reach = (cell[0] * np.abs(points.normal_column) + cell[1] * np.abs(points.normal_row)) / 2
    return np.asarray((off_line <= reach).sum(axis=2))


def _peak_range(votes: NDArray[np.intp], ranges: Floats) -> Floats:
    """Return the range of the fullest connected cells; where that is all, its inner half."""
    full = votes >= FULL_SHARE * votes.max()
    groups, _ = ndimage.label(full)
    fullest = np.unravel_index(int(votes.argmax()), votes.shape)
    own = np.argwhere(groups == groups[fullest])
    shape = np.array(votes.shape)
    size = np.diff(ranges, axis=1)[:, 0]
    low = ranges[:, 0] + (own.min(axis=0) - 0.5) * size / shape
    high = ranges[:, 0] + (own.max(axis=0) + 1.5) * size / shape
    # A range that does not shrink would be looked at for ever.
    widest = size / 2
    middle, half = (low + high) / 2, np.minimum(high - low, widest) / 2
    return np.stack([middle - half, middle + half], 1)


def _radius(distances: Floats, radii: Range, cell_px: float) -> float | None:
    low, high = radii
    for _ in range(MOST_ROUNDS):
        if (high - low) / CELLS <= cell_px:
            break
        votes, _ = np.histogram(distances, CELLS, (low, high))
        if votes.max() == 0:
            return None
        ((low, high),) = _peak_range(votes, np.array([[low, high]])).tolist()
    return (low + high) / 2
