"""Outlines once more, with what the whole shot has told: the radius, and where the markers are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.assignment import KEEP_OFF_SIGMAS
from analysis.imaging.frame import FilmEdges, FrameEdges
from analysis.imaging.outlines import fit_outlines
from analysis.imaging.tracks import Spheres, Track, frames_of
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
    frames: Sequence[FrameEdges] | FilmEdges,
    views: tuple[ViewGeometry, ...],
    spheres: Spheres,
    known: Knowledge,
    sigma_px: float,
) -> Spheres:
    """Fit every outline again with its radius held and the limb's marked stretches left out."""
    refined: Spheres = (
        {g.view: Track(g.view) for g in views},
        {g.view: Track(g.view) for g in views},
    )
    seats = [(i, geometry) for i in (0, 1) for geometry in views]
    limits = KEEP_OFF_SIGMAS * sigma_px, True
    blurred = BLURRED_SIGMAS * sigma_px
    shadows = [_in_plane(known.markers[i], geometry) for i, geometry in seats]
    most = max((len(own) for shadow in shadows for own in shadow.values()), default=0)
    for k in frames_of(spheres):
        here = [n for n, (i, g) in enumerate(seats) if k in spheres[i][g.view].outlines]
        own = [seats[n] for n in here]
        circles = [spheres[i][g.view].outlines[k].circle for i, g in own]
        discs = np.array([(c.row, c.column, c.radius) for c in circles])
        starts = discs.copy()
        starts[:, 2] = [known.radii[g.view][i] for i, g in own]
        hidden = np.full((len(own), most, 2), np.nan)
        for row, n in enumerate(here):
            shadow = shadows[n].get(k, hidden[0, :0])
            hidden[row, : len(shadow)] = shadow
        margins = np.cos(known.marker_angle + blurred / starts[:, 2])
        again = fit_outlines(frames[k].points, starts, discs, (hidden, margins), limits)
        for (i, geometry), outline in zip(own, again, strict=True):
            if outline is not None:
                refined[i][geometry.view].outlines[k] = outline
    return refined


def _in_plane(markers: MarkersInFrame, geometry: ViewGeometry) -> dict[int, Floats]:
    """Return the parts in the image of the markers' directions by frame, shape (markers, 2)."""
    if not markers:
        return {}
    parts = geometry.offsets(np.array(list(markers.values())))[..., :2]
    return dict(zip(markers, parts, strict=True))
