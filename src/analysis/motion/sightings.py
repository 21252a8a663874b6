"""All markers of a sphere in every frame, both views together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from analysis.imaging.markers import Marker
from analysis.imaging.outlines import Outline, Place
from analysis.imaging.tracks import Spheres, other_discs
from analysis.imaging.views import View, ViewGeometry
from analysis.motion.pattern import Sightings

Finder = Callable[[int, Outline, float, ViewGeometry, list[Place]], list[Marker]]
"""Finds the markers of one sphere in one view of a frame: index of the frame, outline, radius in
pixels, view, the frame's other discs."""


@dataclass(frozen=True, slots=True)
class SeenMarker:
    """A marker and the view that shows it."""

    view: View
    marker: Marker


def seen_markers(
    find: Finder,
    views: tuple[ViewGeometry, ...],
    spheres: Spheres,
    sphere: int,
    radii: dict[View, tuple[float, float]],
) -> dict[int, list[SeenMarker]]:
    """Find the markers of one sphere (0: a, 1: b) in every frame that has an outline of it."""
    seen: dict[int, list[SeenMarker]] = {}
    for geometry in views:
        view = geometry.view
        for k, outline in spheres[sphere][view].outlines.items():
            others = other_discs(spheres, k, outline)
            found = find(k, outline, radii[view][sphere], geometry, others)
            seen.setdefault(k, []).extend(SeenMarker(view, marker) for marker in found)
    return seen


def sightings(seen: dict[int, list[SeenMarker]]) -> dict[int, Sightings]:
    """Return the directions of the markers of one sphere by frame."""
    return {
        k: Sightings(
            directions=np.array([m.marker.direction for m in markers]).reshape(-1, 3),
            facing=np.array([m.marker.facing for m in markers]),
        )
        for k, markers in seen.items()
    }


def marker_angle(
    seen: tuple[dict[int, list[SeenMarker]], ...], radii: dict[View, tuple[float, float]]
) -> float:
    """Return the median angular radius of the markers, radians; 0 where none is seen."""
    sizes = [
        m.marker.ellipse.semi_major / radii[m.view][i]
        for i, sphere in enumerate(seen)
        for markers in sphere.values()
        for m in markers
    ]
    return float(np.arcsin(min(np.median(sizes), 1.0))) if sizes else 0.0
