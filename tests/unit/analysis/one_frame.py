"""Outlines and markers of one frame, by the functions that a whole film is searched with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.edge.facet import EdgePoints
from analysis.imaging.edge.frame import FrameEdges
from analysis.imaging.limb import Hidden, settle_outlines
from analysis.imaging.marker.marker_curves import dark_ellipses
from analysis.imaging.marker.markers import Markers, SeenDisc
from analysis.imaging.outlines import Outline, Place
from analysis.imaging.shells import Circle
from analysis.imaging.views import View

Floats = NDArray[np.float64]


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
    """Fit several outlines of one frame.

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


def find_markers(
    edges: FrameEdges, discs: Sequence[SeenDisc], others: Sequence[Place] = ()
) -> tuple[Markers, NDArray[np.intp]]:
    """Find the markers in the discs of one frame.

    Parameters
    ----------
    others
        Further discs of the frame. A curve that reaches into another disc may be a marker of
        either sphere and is left out.

    Returns
    -------
    The markers of all discs, one disc after the other, and the number up to the end of each,
    shape (discs,).
    """
    points = edges.points
    curves = points.row, points.column, points.normal_row, points.normal_column
    around = np.array([*(disc.place() for disc in discs), *others]).reshape(-1, 3)
    places = around[: len(discs)].copy()
    places[:, 2] = [disc.radius_px for disc in discs]
    front = np.array([disc.geometry.view is View.FRONT for disc in discs], dtype=np.bool_)
    ellipses, directions, facing, own, ends = dark_ellipses(
        curves, edges.labels, places, around, front
    )
    return Markers(ellipses, directions, facing, front[own]), ends
