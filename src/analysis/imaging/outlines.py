"""The outline of a sphere: a circle through the edge points that belong to its limb."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.facet import EdgePoints
from analysis.imaging.shells import Circle, fit_circles

Floats = NDArray[np.float64]

Place = tuple[float, float, float]
"""Row, column and radius of a disc, pixels."""

LIMB_REACH_PX = 3.0
"""Edge points this far from the present circle may belong to the limb."""
LEAST_ALIGNMENT = 0.95
"""Cosine between an edge's normal and the radius: a marker that cuts the limb turns the edge."""
NOISE_DISTANCES_PX = (1.5, 0.6, 0.3)
"""The noise cluster draws in as the fit settles, so a poor start does not lose the limb."""
SECTORS = 36


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A fitted outline.

    Attributes
    ----------
    circle
        Centre and radius in pixels with their covariance.
    coverage
        Share of 10 degree sectors of the rim that hold accepted edge points, 0 to 1.
    points
        Accepted edge points (row, column) in pixels, shape (points, 2).
    """

    circle: Circle
    coverage: float
    points: Floats


def fit_outline(
    points: EdgePoints,
    start: Place,
    others: Sequence[Place],
    keep_off_px: float,
    *,
    hold_radius: bool = False,
    blocked: NDArray[np.bool_] | None = None,
) -> Outline | None:
    """Fit one sphere's outline, starting within about 3 pixels of it.

    Parameters
    ----------
    points
        Edge points of the frame.
    start
        Where the disc is expected.
    others
        The frame's other discs: an edge point inside one of them, or within `keep_off_px` of it,
        may be its edge or be blurred by it, and is not used.
    hold_radius
        Keep the radius of `start`.
    blocked
        Edge points not to be used for another reason, shape (points,).

    Returns
    -------
    None where fewer than 12 edge points remain.
    """
    free = np.ones(len(points), dtype=np.bool_) if blocked is None else ~blocked
    for other_row, other_column, other_radius in others:
        gap = np.hypot(points.row - other_row, points.column - other_column) - other_radius
        free &= gap > keep_off_px
    circle = Circle(*start, np.zeros((3, 3)))
    u = np.zeros((1, 0))
    limb = np.zeros(0, dtype=np.intp)
    for noise_distance in NOISE_DISTANCES_PX:
        limb = _limb_points(points, circle, free)
        if limb.size < 12:
            return None
        fitted, u = fit_circles(
            points.row[limb],
            points.column[limb],
            [circle],
            noise_distance=noise_distance,
            hold_radius=hold_radius,
        )
        circle = fitted[0]
    accepted = limb[u[0] > 0.5]
    return Outline(
        circle=circle,
        coverage=_coverage(points, circle, accepted),
        points=np.stack([points.row[accepted], points.column[accepted]], 1),
    )


def _limb_points(points: EdgePoints, circle: Circle, free: NDArray[np.bool_]) -> NDArray[np.intp]:
    d_r, d_c = points.row - circle.row, points.column - circle.column
    rho = np.maximum(np.hypot(d_r, d_c), 1e-9)
    alignment = np.abs(points.normal_row * d_r + points.normal_column * d_c) / rho
    near = np.abs(rho - circle.radius) < LIMB_REACH_PX
    return np.flatnonzero(free & near & (alignment > LEAST_ALIGNMENT))


def _coverage(points: EdgePoints, circle: Circle, accepted: NDArray[np.intp]) -> float:
    angle = np.arctan2(points.column[accepted] - circle.column, points.row[accepted] - circle.row)
    sector = np.floor((angle / (2 * np.pi) + 0.5) * SECTORS).astype(np.intp) % SECTORS
    return float(np.unique(sector).size / SECTORS)
