"""Outlines once more, with what the whole shot has told: the radius, and where the markers are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.imaging.assignment import KEEP_OFF_SIGMAS
from analysis.imaging.film_discs import FilmDiscs, film_discs
from analysis.imaging.film_following import FilmCurves
from analysis.imaging.film_passes import refit_discs
from analysis.imaging.views import View, ViewGeometry

BLURRED_SIGMAS = 1.5
"""The filter carries a marker's edge this many sigma along the limb."""


@dataclass(frozen=True, slots=True, eq=False)
class Appearance:
    """What a first look at the whole shot has told.

    Attributes
    ----------
    radii
        For each view the radius of a and b, pixels.
    markers
        Directions of a's and of b's markers in rig axes, shape (frames, markers, 3); NaN in a
        frame where they are not known, which is refitted whole.
    marker_angle
        Angular radius of a marker, radians.
    """

    radii: dict[View, tuple[float, float]]
    markers: tuple[Floats, Floats]
    marker_angle: float


def refine_outlines(
    curves: FilmCurves,
    views: tuple[ViewGeometry, ...],
    discs: FilmDiscs,
    known: Appearance,
    sigma_px: float,
) -> FilmDiscs:
    """Fit every outline again with its radius held and the limb's marked stretches left out.

    Parameters
    ----------
    curves
        Edges of the film.
    """
    geometry = {own.view: own for own in views}
    seats = [(i, view) for i in (0, 1) for view in discs.views]
    radii = np.array([known.radii[view][i] for i, view in seats])
    most = max(own.shape[1] for own in known.markers)
    hidden = np.full((len(seats), discs.coverage.shape[-1], most, 2), np.nan)
    for own, (i, view) in zip(hidden, seats, strict=True):
        markers = known.markers[i]
        own[:, : markers.shape[1]] = geometry[view].offsets(markers)[..., :2]
    margins = np.cos(known.marker_angle + BLURRED_SIGMAS * sigma_px / radii)
    limits = KEEP_OFF_SIGMAS * sigma_px, True
    again = refit_discs(curves, discs.flat(), radii, (hidden, margins), limits)
    return film_discs(discs.views, again)
