"""The dark markers on a sphere: closed edges inside its outline, each an ellipse (thesis, 4.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.ellipse_shells import fit_ellipse
from analysis.imaging.frame import FrameEdges
from analysis.imaging.outlines import Outline
from analysis.imaging.shells import Ellipse
from analysis.imaging.views import ViewGeometry

Floats = NDArray[np.float64]

INNER_RADIUS = 0.93
"""A curve reaching beyond this share of the radius is the outline's, or touches it."""
FURTHEST_CENTRE = 0.88
"""Markers nearer to the limb are too foreshortened to be measured (about 60 degrees)."""
LEAST_CLOSURE = 0.8
LEAST_OUTWARD = 0.7
LARGEST_SEMI_AXIS = 0.45
MOST_RMS_PX = 0.4


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
    d_r = (points.row - outline.circle.row) / radius_px
    d_c = (points.column - outline.circle.column) / radius_px
    rho = np.hypot(d_r, d_c)
    markers = []
    for label in np.unique(edges.labels[rho < FURTHEST_CENTRE]):
        members = np.flatnonzero(edges.labels == label)
        if label == 0 or rho[members].max() > INNER_RADIUS:
            continue
        if _reaches(points.row[members], points.column[members], others):
            continue
        normals = np.stack([points.normal_row[members], points.normal_column[members]], 1)
        ellipse = _closed_dark(points.row[members], points.column[members], normals, radius_px)
        if ellipse is None:
            continue
        marker = _lift(ellipse, outline, radius_px, geometry)
        if marker is not None:
            markers.append(marker)
    return markers


def _reaches(row: Floats, column: Floats, others: list[tuple[float, float, float]]) -> bool:
    return any(bool((np.hypot(row - r, column - c) < size + 1.0).any()) for r, c, size in others)


def _closed_dark(row: Floats, column: Floats, normals: Floats, radius_px: float) -> Ellipse | None:
    """Fit an ellipse where the curve closes around something darker than its surroundings."""
    if row.size < 8:
        return None
    outward = np.stack([row - row.mean(), column - column.mean()], 1)
    outward /= np.maximum(np.hypot(outward[:, 0], outward[:, 1]), 1e-9)[:, None]
    if (outward * normals).sum(axis=1).mean() < LEAST_OUTWARD:
        return None
    angle = np.arctan2(outward[:, 1], outward[:, 0])
    sectors = np.unique(np.floor((angle / (2 * np.pi) + 0.5) * 12).astype(np.intp) % 12)
    if sectors.size < LEAST_CLOSURE * 12:
        return None
    ellipse = fit_ellipse(row, column)
    if ellipse is None or ellipse.rms_px > MOST_RMS_PX:
        return None
    return ellipse if ellipse.semi_major < LARGEST_SEMI_AXIS * radius_px else None


def _lift(
    ellipse: Ellipse, outline: Outline, radius_px: float, geometry: ViewGeometry
) -> Marker | None:
    """Turn the ellipse's centre into a direction.

    The edge of a round marker is a circle in a plane at R cos(alpha) from the sphere's centre, so
    the ellipse's centre is the marker's projection shortened by cos(alpha); the thesis's lift,
    equation (5-5), leaves that out.
    """
    size = min(ellipse.semi_major / radius_px, 0.5)
    cos_alpha = np.sqrt(1.0 - size**2)
    offset = np.array([ellipse.row - outline.circle.row, ellipse.column - outline.circle.column])
    offset /= radius_px * cos_alpha
    if np.hypot(*offset) > FURTHEST_CENTRE:
        return None
    direction = geometry.direction(offset[:1], offset[1:])[0]
    return Marker(ellipse, direction, float(geometry.offsets(direction)[2]))
