"""Discs of a film as if they had been found at given places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.film_discs import FilmDiscs
from analysis.imaging.views import View

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class At:
    """An outline: row, column and radius in pixels, what it shows, its errors and its points."""

    row: float = 0.0
    column: float = 0.0
    radius: float = 20.0
    coverage: float = 1.0
    variance: tuple[float, float, float] = (0.0, 0.0, 0.0)
    points: int = 100


def discs_at(
    frames: int, a: dict[View, dict[int, At]], b: dict[View, dict[int, At]] | None = None
) -> FilmDiscs:
    """Return the discs of two spheres by view and frame, the second like the first unless given."""
    views = tuple(a)
    seats = 2, len(views), frames
    circles, covariance = np.zeros((*seats, 3)), np.zeros((*seats, 3, 3))
    coverage, spans = np.full(seats, -1.0), np.zeros((*seats, 2), dtype=np.intp)
    for i, sphere in enumerate((a, b or a)):
        for v, view in enumerate(views):
            for k, own in sphere[view].items():
                circles[i, v, k] = own.row, own.column, own.radius
                covariance[i, v, k] = np.diag(own.variance)
                coverage[i, v, k], spans[i, v, k, 1] = own.coverage, own.points
    return FilmDiscs(views, circles, covariance, coverage, np.zeros((2, 1000)), spans)
