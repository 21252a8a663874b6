"""A picture at the sizes in which discs are sought, as it is and with blotches taken off."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from analysis.arrays import Floats, Singles
from analysis.balls.discs.disc import Disc
from analysis.balls.discs.gradient import Gradient, gradient
from analysis.balls.discs.judging import LEAST_SECTORS, PASSES, false_alarms, fit_circle

CORRELATED = 2.5
"""By how much neighbouring edge points, which share what noise the filter saw, enlarge errors."""
SEARCH_RADIUS_PX = 16.0
"""Larger discs are sought in a smaller picture, where their radius is one to two of these."""
CHANGED = 3.0
"""By how many powers of ten discs of a closed or opened picture must be surer: both round off."""
LEAST_CLEAR = 0.6
"""Share of a rim that is clear of surer discs' rims that counts as a whole one."""
BLOTCH = 0.4
"""Width of the ellipse that takes blotches off, in radii."""


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """One version of the picture at one size."""

    gradient: Gradient
    factor: float
    radii: tuple[float, float]
    margin: float

    def outward(self, value: float) -> float:
        """Return a coordinate of the whole picture."""
        return (value + 0.5) * self.factor - 0.5

    def inward(self, disc: Disc) -> Floats:
        """Return a disc's row, column and radius here."""
        row, column = ((v + 0.5) / self.factor - 0.5 for v in (disc.row, disc.column))
        return np.array([row, column, disc.radius / self.factor])


def levels_of(
    values: Singles,
    radii: tuple[float, float],
    sigma_px: float,
    versions: tuple[int | None, ...],
) -> Iterator[Level]:
    """Return a picture at each size and in each version, for discs of such radii."""
    low, most = radii
    while low < most:
        high = min(2.0 * low, most)
        # Of the radii of this octave the smallest becomes the search's.
        factor = max(1.0, low / SEARCH_RADIUS_PX)
        small = values
        if factor > 1.0:
            size = tuple(max(8, round(side / factor)) for side in values.shape[1::-1])
            small = np.atleast_3d(cv2.resize(values, size, interpolation=cv2.INTER_AREA))
        own = (low / factor, high / factor)
        for version in versions:
            shown = small
            if version is not None:
                width = max(3, 2 * round(0.5 * BLOTCH * math.sqrt(own[0] * own[1])) + 1)
                ellipse = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
                shown = np.atleast_3d(cv2.morphologyEx(small, version, ellipse))
            found = gradient(np.ascontiguousarray(shown), sigma_px, local=len(versions) > 1)
            margin = 0.0 if version is None else CHANGED
            yield Level(found, factor, own, margin)
        low = high


def judged(level: Level, weights: Singles, place: Floats, tests: float) -> Disc | None:
    """Return the circle at a place, in the whole picture's pixels, and how sure it is."""
    fit = fit_circle(level.gradient.edges, weights, np.ascontiguousarray(place), len(PASSES))
    radius, sectors = float(fit[2]), float(fit[6])
    if radius <= 0 or sectors < LEAST_SECTORS * LEAST_CLEAR:
        return None
    if not (0.9 * level.radii[0] < radius < 1.1 * level.radii[1]):
        return None
    field, threshold = level.gradient.field, level.gradient.threshold
    alarms, rim, clear = false_alarms(field, threshold, fit[:3].copy(), tests).tolist()
    if sectors < LEAST_SECTORS * max(LEAST_CLEAR, clear):
        return None
    row_sigma, column_sigma, radius_sigma = (CORRELATED * level.factor * fit[3:6]).tolist()
    return Disc(
        row=level.outward(float(fit[0])),
        column=level.outward(float(fit[1])),
        radius=radius * level.factor,
        row_sigma=row_sigma,
        column_sigma=column_sigma,
        radius_sigma=radius_sigma,
        rim=rim,
        log_alarms=alarms,
    )


def take(level: Level, weights: Singles, disc: Disc) -> None:
    """Take an accepted disc's edges, and the changes there, out of what judges the others."""
    row, column, radius = level.inward(disc).tolist()
    band = max(1.5, 0.05 * radius)
    points = level.gradient.edges
    # Edges come row by row, or half a pixel off.
    reach = radius + band + 2.0
    first, last = np.searchsorted(points[:, 0], [row - reach, row + reach]).tolist()
    away = np.hypot(points[first:last, 0] - row, points[first:last, 1] - column)
    weights[first:last][np.abs(away - radius) <= band] = 0.0
    cv2.circle(
        level.gradient.field[0],
        (round(column), round(row)),
        max(1, round(radius)),
        -1.0,
        thickness=max(1, round(2 * band)),
    )
