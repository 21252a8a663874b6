"""The discs of both spheres in every frame of a film, as arrays."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.imaging.film_following import Outlines
from analysis.imaging.outlines import Outline
from analysis.imaging.shells import Circle
from analysis.imaging.tracks import Spheres, Track
from analysis.imaging.views import View


@dataclass(frozen=True, slots=True, eq=False)
class FilmDiscs:
    """Outlines of spheres a and b in each view, through a film.

    Attributes
    ----------
    views
        In the order of the second axis of all that follows.
    circles
        Row, column and radius, pixels, shape (2, views, frames, 3); anything in a frame without.
    covariance
        Of each circle, shape (2, views, frames, 3, 3).
    coverage
        Share of the rim that is seen, shape (2, views, frames); negative in a frame without.
    accepted
        Rows and columns of the edge points on each limb, one outline after the other, shape
        (2, room).
    spans
        Where the points of each begin and end, shape (2, views, frames, 2).
    """

    views: tuple[View, ...]
    circles: Floats
    covariance: Floats
    coverage: Floats
    accepted: Floats
    spans: NDArray[np.intp]

    @property
    def found(self) -> NDArray[np.bool_]:
        """Where there is an outline, shape (2, views, frames)."""
        return self.coverage >= 0.0

    def swapped(self) -> FilmDiscs:
        """Return the same discs with the names of the spheres changed over."""
        names = "circles", "covariance", "coverage", "spans"
        return replace(self, **{name: getattr(self, name)[::-1].copy() for name in names})

    def tracks(self) -> Spheres:
        """Return the outlines by sphere, view and frame."""
        first, second = (
            {view: self._track(i, v) for v, view in enumerate(self.views)} for i in (0, 1)
        )
        return first, second

    def flat(self) -> tuple[Floats, Floats]:
        """Return circles and coverages with one axis of discs, those of a first."""
        frames = self.coverage.shape[-1]
        return self.circles.reshape(-1, frames, 3), self.coverage.reshape(-1, frames)

    def _track(self, sphere: int, v: int) -> Track:
        own = sphere, v
        frames = np.flatnonzero(self.coverage[own] >= 0.0).tolist()
        places, shares = self.circles[own].tolist(), self.coverage[own].tolist()
        spans, covariance = self.spans[own].tolist(), self.covariance[own]
        outlines = {}
        for k in frames:
            row, column, radius = places[k]
            points = self.accepted[:, spans[k][0] : spans[k][1]].T
            outlines[k] = Outline(Circle(row, column, radius, covariance[k]), shares[k], points)
        return Track(self.views[v], outlines)


def film_discs(views: tuple[View, ...], outlines: Outlines) -> FilmDiscs:
    """Return the discs of a in each view, then those of b, as spheres and views."""
    circles, covariance, coverage, accepted, spans = outlines
    seats = 2, len(views), coverage.shape[-1]
    return FilmDiscs(
        views,
        circles.reshape(*seats, 3),
        covariance.reshape(*seats, 3, 3),
        coverage.reshape(seats),
        accepted,
        spans.reshape(*seats, 2),
    )
