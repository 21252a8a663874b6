"""The one disc of a frame by each of the ways that the thesis compares, and by grey levels.

Sobel's and Canny's edges are ridges of the gradient (thesis, 2.2.1); their points lie at pixel
centres. The adaptive Hough transform finds one circle (thesis, 2.2.2 and 4.4): J. Illingworth and
J. Kittler, IEEE Trans. PAMI 9, 690-698 (1987), doi:10.1109/TPAMI.1987.4767964. A small accumulator
is laid over the centre's range, its fullest part becomes the next range, and so on until a cell is
small enough: first for the centre, which lies on every edge point's normal, then for the radius.
"""

from __future__ import annotations

from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from analysis.arrays import Floats, Grey
from analysis.errors import ShotRefusedError
from analysis.imaging.discs import common_radius, discs, vote
from analysis.imaging.edge.edges import gaussian_kernels, laplacian_of_gaussian
from analysis.imaging.edge.expansion import expanded_zero_crossings
from analysis.imaging.edge.facet import EdgePoints, edge_points
from analysis.imaging.edge.frame import EdgeSettings, find_edges, gradient_threshold, noise_sd
from analysis.imaging.outlines import Place
from analysis.imaging.shells import Circle, fit_circles
from analysis.qualification.grey_discs import fit_grey_discs

Way = Literal["pixel", "thirds", "quarters", "exact", "aht", "sobel", "canny", "photometric"]
WAYS: tuple[Way, ...] = get_args(Way)
"""Edges of the filter of width 2 at pixels, at thirds and quarters of a pixel and at the facet's
exact root, all with fuzzy shells; the adaptive Hough transform on those at quarters; ridges of
Sobel's and Canny's gradient with fuzzy shells; grey levels."""

THESIS_SIGMA_PX = 2.0
SAMPLES = {"pixel": 1, "thirds": 3, "quarters": 4, "aht": 4}
REACH_PX = 3.0
NOISE_DISTANCE_PX = 1.5
LEAST_RIM_SHARE = 0.2
SAME_SIZE = 1.05
AROUND_PX = 6.0
RIDGE_FACTOR = 2.0
"""A ridge is a maximum of noise too: its threshold is this much higher."""


def find_disc(frame: Grey, smallest_px: float, largest_px: float) -> Place:
    """Return the most complete disc of a frame, to about a pixel.

    Parameters
    ----------
    smallest_px, largest_px
        Range of its radius.

    Raises
    ------
    ShotRefusedError
        No disc shows a fifth of its rim.
    """
    settings = EdgeSettings()
    threshold = gradient_threshold(noise_sd(frame[None]), settings.sigma_px)
    edges = find_edges(frame, settings, threshold)
    radius = common_radius(edges.points, edges.shape, (smallest_px, largest_px), {1.0: 1})
    found = discs(vote(edges.points, radius, edges.shape), LEAST_RIM_SHARE, radius)
    if not found:
        raise ShotRefusedError(
            "outlines", f"no disc of {smallest_px:.0f} to {largest_px:.0f} px in radius shows"
        )
    return found[0].row, found[0].column, radius


def follow_disc(frames: Grey, smallest_px: float, largest_px: float) -> list[Place]:
    """Return the most complete disc of every frame, to about a pixel.

    The first frame tells the radius; the others have the same to a few per cent.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).

    Raises
    ------
    ShotRefusedError
        As for `find_disc`.
    """
    first = find_disc(frames[0], smallest_px, largest_px)
    near = (first[2] / SAME_SIZE, first[2] * SAME_SIZE)
    return [first, *(find_disc(frame, *near) for frame in frames[1:])]


def locate(frames: Grey, starts: list[Place], way: Way) -> list[Place]:
    """Return row, column and radius of the disc in each frame, pixels.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).
    starts
        Where the disc stands in each frame, within about a pixel.

    Raises
    ------
    ShotRefusedError
        The adaptive Hough transform finds no circle.
    """
    if way == "photometric":
        fitted = fit_grey_discs(frames, starts, shaded=True)
        return [(float(row), float(column), fitted.radius) for row, column in fitted.centres]
    noise = noise_sd(frames)
    return [
        _by_edges(_limb(_edges(frame, noise, way), start), start, way)
        for frame, start in zip(frames, starts, strict=True)
    ]


def _edges(frame: Grey, noise: float, way: Way) -> EdgePoints:
    threshold = gradient_threshold(noise, THESIS_SIGMA_PX)
    if way == "sobel":
        return sobel_edges(frame, RIDGE_FACTOR * gradient_threshold(noise, 1.0))
    if way == "canny":
        return canny_edges(frame, RIDGE_FACTOR * gradient_threshold(noise, 1.0))
    edges = laplacian_of_gaussian(frame, THESIS_SIGMA_PX)
    if way == "exact":
        return edge_points(edges, threshold)
    return expanded_zero_crossings(edges, threshold, SAMPLES[way])


def _limb(points: EdgePoints, start: Place) -> EdgePoints:
    off = np.hypot(points.row - start[0], points.column - start[1]) - start[2]
    return points.where(np.abs(off) < REACH_PX)


def _by_edges(limb: EdgePoints, start: Place, way: Way) -> Place:
    if way == "aht":
        rows, columns, radii = ((at - AROUND_PX, at + AROUND_PX) for at in start)
        found = adaptive_hough(limb, rows, columns, radii)
        if found is None:
            raise ShotRefusedError("outlines", "the adaptive Hough transform finds no circle")
        return found
    guess = Circle(*start, np.zeros((3, 3)))
    (circle,), _ = fit_circles(limb.row, limb.column, [guess], noise_distance=NOISE_DISTANCE_PX)
    return circle.row, circle.column, circle.radius


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
