"""All markers of both spheres in every frame, both views together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Grey
from analysis.imaging.film_discs import FilmDiscs
from analysis.imaging.film_following import FilmCurves
from analysis.imaging.film_passes import film_ellipses
from analysis.imaging.marker.dark_places import find_dark_places
from analysis.imaging.marker.marker_curves import FURTHEST_CENTRE, LARGEST_SINE
from analysis.imaging.marker.markers import FilmMarkers, Markers, SeenDisc, film_markers
from analysis.imaging.views import View, ViewGeometry

Radii = dict[View, tuple[float, float]]
"""Radius of a and of b in each view, pixels."""

SeenMarkers = tuple[FilmMarkers, FilmMarkers]
"""Markers of a and of b."""


def markers_by_edges(curves: FilmCurves, discs: FilmDiscs, radii: Radii) -> SeenMarkers:
    """Find the markers in every disc of a film as closed edges."""
    views = discs.views
    sizes = np.array([radii[view][i] for i in (0, 1) for view in views])
    front = np.array([view is View.FRONT for _ in (0, 1) for view in views])
    found = film_ellipses(curves, discs.flat(), sizes, front)
    ellipses, directions, facing, disc, frame = found
    every = Markers(ellipses, directions, facing, front[disc])
    first, second = (
        _of_sphere(every.where(own), frame[own], discs.found[i].any(axis=0))
        for i, own in enumerate((disc < len(views), disc >= len(views)))
    )
    return first, second


def _of_sphere(every: Markers, frame: NDArray[np.intp], shown: NDArray[np.bool_]) -> FilmMarkers:
    frames = np.flatnonzero(shown)
    ends = np.cumsum(np.bincount(frame, minlength=len(shown))[frames])
    return FilmMarkers(frames, ends, every)


def markers_by_darkness(
    frames: Grey,
    views: tuple[ViewGeometry, ...],
    discs: FilmDiscs,
    radii: Radii,
    least: tuple[float, float],
) -> SeenMarkers:
    """Find the markers in every disc of a film as dark places (`dark_places`).

    Parameters
    ----------
    least
        Share of the light that they lack at least, and the noise of a pixel, grey levels.
    """
    spheres = discs.tracks()
    seen: tuple[dict[int, Markers], dict[int, Markers]] = ({}, {})
    for k in map(int, np.flatnonzero(discs.found.any(axis=(0, 1)))):
        here: list[SeenDisc] = []
        count = [0, 0]
        for i, sphere in enumerate(spheres):
            for geometry in views:
                outline = sphere[geometry.view].outlines.get(k)
                if outline is not None:
                    here.append(SeenDisc(outline, radii[geometry.view][i], geometry))
                    count[i] += 1
        markers, ends = find_dark_places(frames[k], here, noise=least[1], least_darkness=least[0])
        middle = int(ends[count[0] - 1]) if count[0] else 0
        for i, own in ((0, slice(0, middle)), (1, slice(middle, None))):
            if count[i]:
                seen[i][k] = markers.where(own)
    return film_markers(seen[0]), film_markers(seen[1])


def lifted_again(seen: FilmMarkers, discs: FilmDiscs, sphere: int, radii: Radii) -> FilmMarkers:
    """Direct the markers of one sphere anew from the middles of other outlines (`lift`).

    Markers without an outline, or too near to its limb, are left out.
    """
    every, frame = seen.every, seen.frames[seen.frame_of_each()]
    view = np.where(every.front, *(_index(discs, own) for own in (View.FRONT, View.TOP)))
    radius = np.array([radii[own][sphere] for own in discs.views])[view]
    centre = discs.circles[sphere, view, frame, :2]
    sine = np.minimum(every.ellipses[:, 2] / radius, LARGEST_SINE)
    reach = radius * np.sqrt(1.0 - sine**2)
    down, across = ((every.ellipses[:, :2] - centre) / reach[:, None]).T
    square = down**2 + across**2
    kept = (square <= FURTHEST_CENTRE**2) & discs.found[sphere, view, frame]
    facing = np.sqrt(1.0 - np.where(kept, square, 0.0))
    front = np.stack([down, across, facing], axis=1)
    top = np.stack([-facing, across, -down], axis=1)
    directions = np.where(every.front[:, None], front, top)
    return seen.where(kept, Markers(every.ellipses, directions, facing, every.front))


def _index(discs: FilmDiscs, view: View) -> int:
    return discs.views.index(view) if view in discs.views else 0


def marker_angle(seen: SeenMarkers, radii: Radii) -> float:
    """Return the median angular radius of the markers, radians; 0 where none is seen."""
    sizes = []
    for i, sphere in enumerate(seen):
        own, top = sphere.every, radii.get(View.TOP, radii[View.FRONT])[i]
        sizes.append(own.ellipses[:, 2] / np.where(own.front, radii[View.FRONT][i], top))
    every = np.concatenate(sizes)
    return float(np.arcsin(min(np.median(every), 1.0))) if every.size else 0.0
