"""The dark markers on a sphere: closed edges inside its outline, each an ellipse (thesis, 4.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part
from analysis.imaging.ellipse_shells import settle_ellipse
from analysis.imaging.frame import FrameEdges
from analysis.imaging.outlines import Outline
from analysis.imaging.shells import Ellipse
from analysis.imaging.views import ViewGeometry

Floats = NDArray[np.float64]
Curves = tuple[Floats, Floats, Floats, Floats]
"""Rows, columns and unit normals (row, column) of edge points, shape (points,) each."""

INNER_RADIUS = 0.93
"""A curve reaching beyond this share of the radius is the outline's, or touches it."""
FURTHEST_CENTRE = 0.88
"""Markers nearer to the limb are too foreshortened to be measured (about 60 degrees)."""
LEAST_CLOSURE = 0.8
LEAST_OUTWARD = 0.7
LARGEST_SEMI_AXIS = 0.45
MOST_RMS_PX = 0.4
SECTORS, LEAST_POINTS = 12, 8
ITERATIONS, SETTLED = 30, 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Marker:
    """A marker seen in one view of one frame.

    Attributes
    ----------
    ellipse
        Its edge in the image, pixels.
    direction
        Unit vector from the sphere's centre to the marker, rig axes, shape (3,).
    facing
        Cosine of the angle between that direction and the line of sight: 1 at the disc's middle.
    """

    ellipse: Ellipse
    direction: Floats
    facing: float


def find_markers(
    edges: FrameEdges,
    outline: Outline,
    radius_px: float,
    geometry: ViewGeometry,
    others: list[tuple[float, float, float]],
) -> list[Marker]:
    """Find the markers of one sphere in one view.

    Parameters
    ----------
    outline
        The sphere's outline in this view.
    radius_px
        Its radius as all frames together give it.
    others
        The other discs (row, column, radius) of the frame. A curve that reaches into one may be a
        marker of either sphere and is left out.
    """
    points = edges.points
    curves = points.row, points.column, points.normal_row, points.normal_column
    place = outline.circle.row, outline.circle.column, float(radius_px)
    discs = np.array(others, dtype=np.float64).reshape(-1, 3)
    ellipses = [Ellipse(*own) for own in dark_ellipses(curves, edges.labels, place, discs).tolist()]
    lifted = (_lift(ellipse, outline, radius_px, geometry) for ellipse in ellipses)
    return [marker for marker in lifted if marker is not None]


@part
def inner_curves(
    curves: Curves, labels: NDArray[np.int32], place: tuple[float, float, float], others: Floats
) -> tuple[NDArray[np.intp], Floats]:
    """Return the size of each curve inside a disc, 0 for any other, and its middle.

    A curve that reaches beyond INNER_RADIUS, stays beyond FURTHEST_CENTRE or comes near another
    disc counts as another.
    """
    most = labels.max() + 1 if labels.size else 1
    size, middle = np.zeros(most, dtype=np.intp), np.zeros((most, 2))
    left_out, inner = np.zeros(most, dtype=np.bool_), np.zeros(most, dtype=np.bool_)
    for k in range(labels.size):
        name, row, column = labels[k], curves[0][k], curves[1][k]
        square = (row - place[0]) ** 2 + (column - place[1]) ** 2
        if square > (INNER_RADIUS * place[2]) ** 2:
            left_out[name] = True
            continue
        if square < (FURTHEST_CENTRE * place[2]) ** 2:
            inner[name] = True
        for n in range(others.shape[0]):
            reach = others[n, 2] + 1.0
            if (row - others[n, 0]) ** 2 + (column - others[n, 1]) ** 2 < reach * reach:
                left_out[name] = True
        size[name] += 1
        middle[name, 0] += row
        middle[name, 1] += column
    for name in range(most):
        if name == 0 or left_out[name] or not inner[name] or size[name] < LEAST_POINTS:
            size[name] = 0
        else:
            middle[name] /= size[name]
    return size, middle


@compiled
def dark_ellipses(
    curves: Curves, labels: NDArray[np.int32], place: tuple[float, float, float], others: Floats
) -> Floats:
    """Fit an ellipse to each curve in a disc that closes around something dark.

    Parameters
    ----------
    labels
        Of each point, shape (points,).
    place
        Row, column and radius of the disc, pixels.
    others
        The frame's other discs, shape (others, 3).

    Returns
    -------
    In the order of `shells.Ellipse`, shape (ellipses, 6).
    """
    size, middle = inner_curves(curves, labels, place, others)
    outward, sectors = np.zeros(size.size), np.zeros((size.size, SECTORS))
    for k in range(labels.size):
        name = labels[k]
        if size[name] == 0:
            continue
        d_r, d_c = curves[0][k] - middle[name, 0], curves[1][k] - middle[name, 1]
        length = max(math.hypot(d_r, d_c), 1e-9)
        outward[name] += (d_r * curves[2][k] + d_c * curves[3][k]) / length
        angle = math.atan2(d_c, d_r) / (2 * math.pi) + 0.5
        sectors[name, math.floor(angle * SECTORS) % SECTORS] = 1.0
    found = np.empty((size.size, 6))
    count = 0
    for name in range(1, size.size):
        if size[name] == 0 or outward[name] < LEAST_OUTWARD * size[name]:
            continue
        if sectors[name].sum() < LEAST_CLOSURE * SECTORS:
            continue
        own, ellipse = labels == name, found[count]
        if not settle_ellipse(curves[0][own], curves[1][own], (ITERATIONS, SETTLED), ellipse):
            continue
        if ellipse[5] <= MOST_RMS_PX and ellipse[2] < LARGEST_SEMI_AXIS * place[2]:
            count += 1
    return found[:count]


def _lift(
    ellipse: Ellipse, outline: Outline, radius_px: float, geometry: ViewGeometry
) -> Marker | None:
    """Turn the ellipse's centre into a direction.

    The edge of a round marker is a circle in a plane at R cos(alpha) from the sphere's centre, so
    the ellipse's centre is the marker's projection shortened by cos(alpha); the thesis's lift,
    equation (5-5), leaves that out.
    """
    size = min(ellipse.semi_major / radius_px, 0.5)
    cos_alpha = math.sqrt(1.0 - size**2)
    lift = radius_px * cos_alpha
    down = (ellipse.row - outline.circle.row) / lift
    across = (ellipse.column - outline.circle.column) / lift
    if math.hypot(down, across) > FURTHEST_CENTRE:
        return None
    facing = math.sqrt(1.0 - down**2 - across**2)
    return Marker(ellipse, geometry.lifted(down, across, facing), facing)
