"""The outline of a sphere: a circle through the edge points that belong to its limb."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.edge.facet import EdgePoints
from analysis.imaging.limb import Hidden, settle_outlines
from analysis.imaging.shells import Circle

Floats = NDArray[np.float64]

Place = tuple[float, float, float]
"""Row, column and radius of a disc, pixels."""


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
    discs = np.array([start, *others], dtype=np.float64)
    seen = points if blocked is None else points.where(~blocked)
    limits = float(keep_off_px), hold_radius
    return fit_outlines(seen, discs[:1], discs, nothing_hidden(1), limits)[0]


def nothing_hidden(outlines: int) -> Hidden:
    """Return that no marker hides any limb."""
    return np.empty((outlines, 0, 2)), np.ones(outlines)


def fit_outlines(
    points: EdgePoints,
    starts: Floats,
    discs: Floats,
    hidden: Hidden,
    limits: tuple[float, bool],
) -> list[Outline | None]:
    """Fit several outlines of one frame, each as `fit_outline` tells.

    Parameters
    ----------
    starts
        Row, column and radius of each, shape (outlines, 3).
    discs
        All discs of the frame, those to be fitted first, shape (discs, 3).
    hidden
        Where markers hide the limbs.
    limits
        Distance to keep off other discs, pixels, and whether radii are held.
    """
    edges = points.row, points.column, points.normal_row, points.normal_column
    places, covariance = starts.copy(), np.zeros((len(starts), 3, 3))
    accepted, ends, coverage = settle_outlines(edges, (places, covariance), discs, hidden, limits)
    found: list[Outline | None] = []
    first = 0
    for place, own, share, end in zip(
        places.tolist(), covariance, coverage.tolist(), ends.tolist(), strict=True
    ):
        row, column, radius = place
        circle = Circle(row, column, radius, own)
        found.append(None if share < 0.0 else Outline(circle, share, accepted[first:end]))
        first = end
    return found
