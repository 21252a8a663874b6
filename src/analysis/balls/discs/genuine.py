"""Whether a rim is that of something round: how sharp its edge is, and that it is no polygon."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.discs.gradient import (
    WIDER,
    gradient,
    gradient_field,
    size_along,
    window_about,
)
from analysis.balls.discs.least_sum import least_sum
from analysis.compiled import compiled

FOLDS = (4, 5, 6, 7, 8)
"""Of the waves about a rim that make it a figure with as many sides or round corners."""
ROUND_BAND, ROUND_ALONG = 0.12, 0.9
"""Distance from a circle in radii, and cosine of the angle with its radius, of a figure's edges."""
LEAST_WAVE, OF_SQUARES, LEAST_CHANCE = 0.015, 0.8, 1e-4
"""Height of a wave in radii, its share of the square of the distances from the circle, and the
chance that scatter makes one: higher, larger and less likely ones are no circle's."""
RECENTRED, LEAST_EDGES = 3, 16
"""How often the circle is moved to the middle of its edges, and how many say anything."""
CORRELATED_POINTS = 2.5
"""Neighbouring edge points, which share what noise the filter saw, that count as one."""
ASIDE, RIM_STEP = 2.5, 0.5
"""How far beside a circle its rim is looked for, in the filter's widths, and in which steps."""


def sharpness(values: Singles, place: Floats, sigma_px: float) -> float:
    """Return how much stronger a narrow filter sees a rim than one `WIDER` times as wide.

    A step that the filter alone blurs has `WIDER`, a slope that is wider than both has 1; noise of
    single pixels has more than both, and by itself makes no circle. The median about the rim
    counts, so that what hides a part of it, or a smear along it, does not.

    Parameters
    ----------
    place
        Row, column and radius, shape (3,).
    sigma_px
        Width of the narrow filter.
    """
    window, corner = window_about(values, place, 2.0 * ASIDE * sigma_px / place[2])
    circle = place - corner
    narrow, wide = (
        _rim_sizes(gradient_field(window, width), circle, sigma_px)
        for width in (sigma_px, WIDER * sigma_px)
    )
    seen = wide > 0.0
    return float(np.median(narrow[seen] / wide[seen])) if seen.any() else 1.0


def is_round(values: Singles, place: Floats, sigma_px: float) -> bool:
    """Return whether a rim is a circle, not a polygon or a square with round corners.

    The distances of its edges from the circle are fitted, to their least sum, with and without a
    wave that goes four to eight times around. A figure is what one such wave describes better than
    scatter may.

    Parameters
    ----------
    place
        Row, column and radius, shape (3,).
    """
    window, corner = window_about(values, place, 2.0 * ROUND_BAND)
    edges = gradient(window, sigma_px).edges.astype(np.float64)
    circle = place - corner
    # A circle through three sides of a square does not lie in its middle.
    for _ in range(RECENTRED):
        turn, distance = _distances(edges, circle)
        if len(turn) < LEAST_EDGES:
            return True
        terms = [np.sin(turn), np.cos(turn), np.ones_like(turn)]
        moved, plain = least_sum(terms, distance)
        circle = circle + moved
    free = 0.5 * (len(turn) / CORRELATED_POINTS - 5.0)
    for fold in FOLDS:
        found, left = least_sum([*terms, np.cos(fold * turn), np.sin(fold * turn)], distance)
        gained = 1.0 - (left / max(plain, 1e-12)) ** 2
        chance = len(FOLDS) * (1.0 - gained) ** free
        high = math.hypot(*found[3:]) > LEAST_WAVE * place[2]
        if high and gained > OF_SQUARES and chance < LEAST_CHANCE:
            return False
    return True


def _distances(edges: Floats, circle: Floats) -> tuple[Floats, Floats]:
    """Return angles at the centre and distances from a circle of the edges that may be its own."""
    off = edges[:, :2] - circle[:2]
    away = np.hypot(*off.T) + 1e-9
    along = np.abs((off * edges[:, 2:]).sum(axis=1)) / away
    own = (np.abs(away - circle[2]) < ROUND_BAND * circle[2]) & (along > ROUND_ALONG)
    return np.arctan2(off[own, 0], off[own, 1]), away[own] - circle[2]


@compiled
def _rim_sizes(
    field: NDArray[np.float32], circle: NDArray[np.float64], sigma_px: float
) -> NDArray[np.float64]:
    """Return the largest part of the gradient along the radius near each sample of a circle."""
    samples = max(24, int(2.0 * math.pi * circle[2]))
    found = np.zeros(samples)
    steps = int(ASIDE / RIM_STEP)
    for k in range(samples):
        angle = 2.0 * math.pi * k / samples
        u, v = math.sin(angle), math.cos(angle)
        for m in range(-steps, steps + 1):
            away = circle[2] + m * RIM_STEP * sigma_px
            row, column = circle[0] + away * u, circle[1] + away * v
            for side in (1.0, -1.0):
                size = size_along(field, row, column, side * u, side * v)
                found[k] = max(found[k], size)
    return found
