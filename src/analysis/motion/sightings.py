"""All markers of a sphere in every frame, both views together."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.markers import Markers, SeenDisc
from analysis.imaging.tracks import Spheres, frames_of
from analysis.imaging.views import View, ViewGeometry
from analysis.motion.pattern import Sightings

Finder = Callable[[int, Sequence[SeenDisc]], tuple[Markers, NDArray[np.intp]]]
"""Finds the markers in the discs of a frame, given its index, as `markers.find_markers` does."""

SeenMarkers = tuple[dict[int, Markers], dict[int, Markers]]
"""Markers of a and of b by frame."""


def seen_markers(
    find: Finder,
    views: tuple[ViewGeometry, ...],
    spheres: Spheres,
    radii: dict[View, tuple[float, float]],
) -> SeenMarkers:
    """Find the markers of both spheres in every frame that has an outline of them."""
    seen: SeenMarkers = ({}, {})
    for k in frames_of(spheres):
        discs: list[SeenDisc] = []
        count = [0, 0]
        for i, sphere in enumerate(spheres):
            for geometry in views:
                outline = sphere[geometry.view].outlines.get(k)
                if outline is not None:
                    discs.append(SeenDisc(outline, radii[geometry.view][i], geometry))
                    count[i] += 1
        markers, ends = find(k, discs)
        middle = int(ends[count[0] - 1]) if count[0] else 0
        for i, own in ((0, slice(0, middle)), (1, slice(middle, None))):
            if count[i]:
                seen[i][k] = markers.where(own)
    return seen


def sightings(seen: dict[int, Markers]) -> dict[int, Sightings]:
    """Return the directions of the markers of one sphere by frame."""
    return {k: Sightings(own.directions, own.facing) for k, own in seen.items()}


def marker_angle(seen: SeenMarkers, radii: dict[View, tuple[float, float]]) -> float:
    """Return the median angular radius of the markers, radians; 0 where none is seen."""
    sizes = []
    for i, sphere in enumerate(seen):
        for own in sphere.values():
            top = radii.get(View.TOP, radii[View.FRONT])[i]
            sizes.append(own.ellipses[:, 2] / np.where(own.front, radii[View.FRONT][i], top))
    every = np.concatenate(sizes) if sizes else np.empty(0)
    return float(np.arcsin(min(np.median(every), 1.0))) if every.size else 0.0
