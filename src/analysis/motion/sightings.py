"""All markers of a sphere in every frame, both views together."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.marker_curves import FURTHEST_CENTRE, LARGEST_SINE
from analysis.imaging.markers import Markers, SeenDisc, joined
from analysis.imaging.tracks import Spheres, Track, frames_of
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


def lifted_again(
    seen: dict[int, Markers], tracks: dict[View, Track], radii_px: dict[View, float]
) -> dict[int, Markers]:
    """Direct the markers of one sphere anew from the middles of other outlines (`lift`).

    Parameters
    ----------
    tracks, radii_px
        Outlines of the sphere, and its radius, in each view. Markers without an outline, or too
        near to its limb, are left out.
    """
    every = joined(list(seen.values()))
    sizes = np.array([len(own) for own in seen.values()], dtype=np.intp)
    frame = np.repeat(np.arange(len(seen)), sizes)
    view, centre = np.where(every.front, 0, 1), np.full((len(seen), 2, 2), np.nan)
    radius = np.array([radii_px.get(own, np.nan) for own in (View.FRONT, View.TOP)])[view]
    for v, track in enumerate(tracks.get(own) for own in (View.FRONT, View.TOP)):
        for n, k in enumerate(seen):
            if track is not None and (place := track.centre(k)) is not None:
                centre[n, v] = place
    sine = np.minimum(every.ellipses[:, 2] / radius, LARGEST_SINE)
    reach = radius * np.sqrt(1.0 - sine**2)
    down, across = ((every.ellipses[:, :2] - centre[frame, view]) / reach[:, None]).T
    square = down**2 + across**2
    kept = square <= FURTHEST_CENTRE**2
    facing = np.sqrt(1.0 - np.where(kept, square, 0.0))
    front = np.stack([down, across, facing], axis=1)
    top = np.stack([-facing, across, -down], axis=1)
    directions = np.where(every.front[:, None], front, top)
    again = Markers(every.ellipses, directions, facing, every.front).where(kept)
    ends = np.cumsum(np.bincount(frame[kept], minlength=len(seen))).tolist()
    starts = [0, *ends][: len(ends)]
    return {k: again.where(slice(a, b)) for k, a, b in zip(seen, starts, ends, strict=True)}


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
