"""Whether a circle is the rim of something round: a sharp edge, seen all around, and no polygon."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.discs.gradient import (
    EXACT_PX,
    WIDER,
    gradient,
    gradient_field,
    size_along,
    window_about,
)
from analysis.balls.discs.judging import SECTORS, sectors
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
LEAST_SUMS = 6
"""Fits with new weights to the least sum of distances: edges of other things hardly count in it."""
CORRELATED_POINTS = 2.5
"""Neighbouring edge points, which share what noise the filter saw, that count as one."""
NEAR_PX = 0.6
CLOSELY, NEARLY = (0.02, math.cos(math.radians(12.0))), (0.03, math.cos(math.radians(15.0)))
"""Distance from a circle in radii, and cosine of the angle with its radius, of edges on it."""
EXACT_RADIUS_PX = 60.0
"""Larger circles are looked at in a smaller picture, where they have this radius."""
LEAST_SEEN, WHOLE_PX, SURE_WHOLE_PX = 0.4, 24.0, 44.0
"""Share of a rim's sectors with edges closely on it, and the radius from which so many are asked
for, of circles that are not sure and of those that are: edges of a smaller one are less exact."""
SURE = -13.0
"""log10 of the false alarms of a circle that is sure."""
LEAST_AMID_PX, AMID = 30.0, 1.7
"""Circles from this radius on, which have much about and in them, are seen so many times more than
any circle beside them; balls in a heap are as large as others."""
BEYOND, AROUND, BESIDE, BESIDE_TURNS = 0.35, 1.1, (0.4, 0.8), 16
"""How far both windows go beyond the circle; how far beside it others lie, in radii, and in how
many directions."""
LEAST_SHOWN = 0.5
BORDER_PX = 2.0
"""Next to the picture's border no edge is found."""
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


def is_seen(values: Singles, place: Floats, sigma_px: float, log_alarms: float) -> bool:
    """Return whether enough of a rim is an edge in the whole picture, and more than beside it.

    Gradients that point to a centre are no rim yet: those of a soft blotch of light or shade do
    everywhere in it, and a cluttered ground has some at each circle's side.

    Parameters
    ----------
    place
        Row, column and radius, shape (3,).
    log_alarms
        log10 of the circle's number of false alarms.
    """
    radius = float(place[2])
    whole = SURE_WHOLE_PX if log_alarms < SURE else WHOLE_PX
    # In a narrow window, as an edge is stronger than what is next to it.
    edges, circle, shape = _edges_about(values, place, sigma_px, BEYOND)
    if _share(edges, circle, shape, CLOSELY) < LEAST_SEEN * min(1.0, radius / whole):
        return False
    if radius < LEAST_AMID_PX:
        return True
    edges, circle, shape = _edges_about(values, place, sigma_px, AROUND)
    turns = 2.0 * np.pi * np.arange(BESIDE_TURNS) / BESIDE_TURNS
    ways = np.stack([np.sin(turns), np.cos(turns), np.zeros_like(turns)], axis=1)
    beside = [circle + off * circle[2] * way for off in BESIDE for way in ways]
    most = max(_share(edges, each, shape, NEARLY) for each in beside)
    return _share(edges, circle, shape, NEARLY) > AMID * most


def _edges_about(
    values: Singles, place: Floats, sigma_px: float, beyond: float
) -> tuple[Singles, Floats, tuple[int, ...]]:
    """Return edges about a circle, the circle, and rows and columns of their window.

    In a smaller picture where the circle is large.
    """
    window, corner = window_about(values, place, beyond)
    circle = place - corner
    factor = max(1.0, float(place[2]) / EXACT_RADIUS_PX)
    if factor > 1.0:
        size = tuple(max(8, round(side / factor)) for side in window.shape[1::-1])
        window = np.atleast_3d(cv2.resize(window, size, interpolation=cv2.INTER_AREA))
        circle = np.array([*((circle[:2] + 0.5) / factor - 0.5), circle[2] / factor])
    return gradient(window, sigma_px).edges, circle, window.shape[:2]


def _share(
    edges: Singles, circle: Floats, shape: tuple[int, ...], near: tuple[float, float]
) -> float:
    """Return the share of a circle's sectors in the picture that have an edge near the circle.

    0 where less than half of the circle is in the picture's window, of `shape`.

    Parameters
    ----------
    near
        Distance in radii, and least cosine of the edge's angle with the radius.
    """
    turns = 2.0 * np.pi * (np.arange(SECTORS) + 0.5) / SECTORS
    places = circle[:2, None] + circle[2] * np.stack([np.sin(turns), np.cos(turns)])
    room = np.array(shape)[:, None] - BORDER_PX
    shown = float(((places > BORDER_PX) & (places < room)).all(axis=0).mean())
    if shown < LEAST_SHOWN:
        return 0.0
    limits = np.array([max(NEAR_PX, near[0] * circle[2]), near[1]])
    return (
        sectors(edges, np.ones(len(edges), np.float32), np.ascontiguousarray(circle), limits)
        / shown
    )


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
        plain, moved = _left(terms, distance)
        circle = circle + moved
    free = 0.5 * (len(turn) / CORRELATED_POINTS - 5.0)
    for fold in FOLDS:
        left, found = _left([*terms, np.cos(fold * turn), np.sin(fold * turn)], distance)
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


def _left(terms: list[Floats], values: Floats) -> tuple[float, Floats]:
    """Return the least sum of sizes of what some terms leave of values, and the terms' sizes."""
    matrix = np.column_stack(terms)
    weights = np.ones_like(values)
    for _ in range(LEAST_SUMS):
        found = np.linalg.lstsq(matrix * weights[:, None], values * weights, rcond=None)[0]
        left = np.abs(values - matrix @ found)
        weights = 1.0 / np.sqrt(np.maximum(left, EXACT_PX))
    return float(left.sum()), np.asarray(found)


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
