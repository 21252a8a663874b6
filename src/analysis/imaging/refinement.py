"""Outlines once more, with what the whole shot has told: the radius, and where the markers are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.assignment import KEEP_OFF_SIGMAS
from analysis.imaging.facet import EdgePoints
from analysis.imaging.frame import FrameEdges
from analysis.imaging.outlines import Outline, fit_outline
from analysis.imaging.tracks import Spheres, Track, other_discs
from analysis.imaging.views import View, ViewGeometry

Floats = NDArray[np.float64]

BLURRED_SIGMAS = 1.5
"""The filter carries a marker's edge this many sigma along the limb."""

MarkersInFrame = dict[int, Floats]
"""Directions of a sphere's markers in rig axes, shape (markers, 3), by frame."""


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """What a first look at the whole shot has told.

    Attributes
    ----------
    radii
        For each view the radius of a and b, pixels.
    markers
        For a and b, where the markers stand in each frame; a frame without is refitted whole.
    marker_angle
        Angular radius of a marker, radians.
    """

    radii: dict[View, tuple[float, float]]
    markers: tuple[MarkersInFrame, MarkersInFrame]
    marker_angle: float


def refine_outlines(
    frames: Sequence[FrameEdges],
    views: tuple[ViewGeometry, ...],
    spheres: Spheres,
    known: Knowledge,
    sigma_px: float,
) -> Spheres:
    """Fit every outline again with its radius held and the limb's marked stretches left out."""
    refined: Spheres = ({}, {})
    keep_off = KEEP_OFF_SIGMAS * sigma_px
    for geometry in views:
        for i, sphere in enumerate(spheres):
            radius = known.radii[geometry.view][i]
            margin = known.marker_angle + BLURRED_SIGMAS * sigma_px / radius
            track = Track(geometry.view)
            for k, outline in sphere[geometry.view].outlines.items():
                points, standing = frames[k].points, known.markers[i].get(k)
                again = fit_outline(
                    points,
                    (outline.circle.row, outline.circle.column, radius),
                    other_discs(spheres, k, outline),
                    keep_off,
                    hold_radius=True,
                    blocked=_on_markers(points, outline, geometry, standing, margin),
                )
                if again is not None:
                    track.outlines[k] = again
            refined[i][geometry.view] = track
    return refined


def _on_markers(
    points: EdgePoints,
    outline: Outline,
    geometry: ViewGeometry,
    markers: Floats | None,
    margin: float,
) -> NDArray[np.bool_] | None:
    """Mark edge points whose place on the limb lies within `margin` radians of a marker."""
    if markers is None or len(markers) == 0:
        return None
    d_r, d_c = points.row - outline.circle.row, points.column - outline.circle.column
    rho = np.maximum(np.hypot(d_r, d_c), 1e-9)
    limb = geometry.direction(d_r / rho, d_c / rho)
    return np.asarray((limb @ markers.T > np.cos(margin)).any(axis=1))
