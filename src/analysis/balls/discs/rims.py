"""The rim of a disc in the whole picture: a circle through edges that shading does not move.

Where light changes along a ball's surface next to its rim, a filter puts the edge where the light
changes most, inside the rim: by up to a tenth of the radius on the side away from the lamp. This
shift grows with the filter's width, so edges of two widths tell it. What is left of it makes an
edge count less: a circle follows the sharp limb, not the soft border of what is lit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

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
from analysis.balls.discs.judging import PASSES, SECTORS, fit_circle
from analysis.compiled import compiled

WIDEST = 2.2
"""Width of a filter, in that of the narrow one, whose edges tell the shifts for an error."""
AS_WIDTH = 0.8
"""Share of a shift that is taken back, as of one that grows as the width: 1 if it does grow so, 0.6
if it grows as the square of the width with the camera's blur added to it."""
SOFT = 0.5
"""Share of a shift that is the error of an edge that shifts."""
REACH, STEP, SPAN = 2.1, 0.2, 3
"""How far along its direction an edge is sought at another width, in widths, in which steps, and
over how many of them to each side its top is found."""

LEAST_RIM = 0.2
"""Share of a rim's sectors with edges: what an arc leaves open is in the errors."""
BEYOND, LEAST_PX = 0.35, 8
GROWN, TURNS = (0.06, 0.12, 0.18, 0.25, -0.06, -0.12), 16
"""Circles that share a side with the one that was found, larger by these shares of its radius."""
STARTING = 3
"""Bands, the widest first, in which a circle is fitted from there."""
LARGER, SMALLER = (1.15, 2.0), (1.45, 6.0)
"""By which share, and by how many sectors, a circle's sharp part is longer than that of the found
one, if it is the rim instead: an arc within an oval coin's rim is sharp as well."""
RIVAL = 0.92
"""Of the sharp part of the rim: another circle with as much may be the rim too."""
FARTHEST, LEAST_GROWN, MOST_GROWN = 0.4, 0.75, 1.5
"""In the found circle's radii: how far its centre lies off, and its radius."""
BAND_PX, BAND_RADII, ALONG = 0.8, 0.03, 0.93
"""Distance from a circle and cosine of the angle with its radius within which edges are its own."""

HALVES, MOST_HALVES = 16, 0.75
"""Circles through each half of a rim, and share of them whose changes count as usual ones."""
OF_SCATTER, OF_SHIFT, OF_WIDEST, OF_RIVAL = 1.6, 0.35, 0.5, 0.2
"""Share of each in an error: see `_errors`."""
OF_HALVES = np.array([0.75, 0.75, 1.3])
"""The same of the halves, of row, column and radius."""
CENTRE_AND_RADIUS = np.array([[0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.0, 0.0, 1.0]])
"""Mean square of the changes of row and column, for both; that of the radius."""


@dataclass(frozen=True, slots=True, eq=False)
class _Edges:
    """Edges of a window at one width and where a filter of no width would have them.

    Attributes
    ----------
    seen, points
        Shape (N, 4): row, column and direction.
    weights
        Shape (N,): 1 for an edge that does not shift with the width.
    """

    seen: Singles
    points: Singles
    weights: Singles


def fit_rim(values: Singles, place: Floats, sigma_px: float) -> tuple[Floats, Floats] | None:
    """Return a circle fitted to the edges of the whole picture, and its errors, each shape (3,).

    Parameters
    ----------
    place
        Row, column and radius of a disc that was found in a smaller picture, shape (3,).
    sigma_px
        Width of the filter that finds edges.

    Returns
    -------
    None where the edges have no circle there.
    """
    window, corner = window_about(values, place, BEYOND)
    if min(window.shape[:2]) < LEAST_PX:
        return None
    seen = gradient(window, sigma_px).edges
    edges = _unshifted(seen, gradient_field(window, WIDER * sigma_px), sigma_px, WIDER)
    start, rivals = _sharpest(edges, place - corner)
    fit = _circle(edges.points, edges.weights, start)
    moved = math.hypot(*(fit[:2] - start[:2]))
    if fit[2] <= 0 or fit[6] < LEAST_RIM or moved > 0.1 * place[2] + 1.0:
        return None
    widest = _unshifted(seen, gradient_field(window, WIDEST * sigma_px), sigma_px, WIDEST)
    return fit[:3] + corner, _errors(fit, edges, widest, rivals)


def _unshifted(seen: Singles, field: Singles, sigma_px: float, wider: float) -> _Edges:
    """Return edges where a filter of no width would have them, from those of a wider one."""
    shifts = _shifts(seen, field, sigma_px)
    there = np.isfinite(shifts)
    own, by = seen[there], shifts[there] / (wider - 1.0)
    points = own.copy()
    points[:, :2] -= AS_WIDTH * by[:, None] * own[:, 2:]
    # Of the shift between one width and a 1.6 times wider one.
    weights = 1.0 / (1.0 + (SOFT * (WIDER - 1.0) * by / EXACT_PX) ** 2)
    rows = np.argsort(points[:, 0], kind="stable")
    return _Edges(own[rows], points[rows], weights[rows].astype(np.float32))


@compiled
def _shifts(
    edges: NDArray[np.float32], field: NDArray[np.float32], sigma_px: float
) -> NDArray[np.float32]:
    """Return how far along their direction edges lie in a field of another width; NaN: nowhere."""
    found = np.full(len(edges), np.nan, np.float32)
    half = round(REACH / STEP) + SPAN
    sizes = np.zeros(2 * half + 1)
    for k in range(len(edges)):
        row, column, u, v = edges[k]
        for m in range(2 * half + 1):
            along = (m - half) * STEP * sigma_px
            sizes[m] = size_along(field, row + along * u, column + along * v, u, v)
        nearest = 2 * half
        for m in range(SPAN, 2 * half + 1 - SPAN):
            top = sizes[m] > 0.0 and sizes[m] >= sizes[m - 1] and sizes[m] > sizes[m + 1]
            if top and abs(m - half) < nearest:
                nearest = abs(m - half)
                before, after = sizes[m - SPAN], sizes[m + SPAN]
                curve = before - 2.0 * sizes[m] + after
                shift = 0.5 * (before - after) / curve if curve < 0.0 else 0.0
                shift = m - half + SPAN * min(1.0, max(-1.0, shift))
                found[k] = shift * STEP * sigma_px
    return found


def _circle(points: Singles, weights: Singles, start: Floats, bands: int = len(PASSES)) -> Floats:
    return fit_circle(points, weights, np.ascontiguousarray(start), bands)


def _sharpest(edges: _Edges, place: Floats) -> tuple[Floats, Floats]:
    """Return the circle at a found one or about it with the longest sharp part, and its rivals.

    The border of what is lit on a ball shares a side with its rim: circles are tried that do.
    Rivals are those whose sharp parts are nearly as long, shape (N, 3).
    """
    angles = 2.0 * np.pi * np.arange(TURNS) / TURNS
    sides = np.stack([np.sin(angles), np.cos(angles), np.ones(TURNS)], axis=1)
    starts = [place, *(place + grown * place[2] * side for grown in GROWN for side in sides)]
    fits = np.array([_circle(edges.points, edges.weights, each, STARTING)[:3] for each in starts])
    near = np.hypot(*(fits[:, :2] - place[:2]).T) < FARTHEST * place[2]
    near &= (LEAST_GROWN * place[2] < fits[:, 2]) & (fits[:, 2] < MOST_GROWN * place[2])
    sharp = np.array([_sharp_sectors(edges.points, edges.weights, each) for each in fits])
    sharp[~near] = 0.0
    least = [max(share * sharp[0], sharp[0] + more) for share, more in (LARGER, SMALLER)]
    there = sharp >= np.where(fits[:, 2] >= fits[0, 2], *least)
    there[0] = True
    best = int(np.argmax(np.where(there, sharp, 0.0)))
    chosen = fits[best] if near[best] else place
    return chosen, fits[near & (sharp > RIVAL * sharp[best])]


@compiled
def _sharp_sectors(
    edges: NDArray[np.float32], weights: NDArray[np.float32], circle: NDArray[np.float64]
) -> float:
    """Return how many sectors of a circle have edges, each as its best edge's weight."""
    best = np.zeros(SECTORS)
    band = max(BAND_PX, BAND_RADII * circle[2])
    for k in range(len(edges)):
        dr, dc = edges[k, 0] - circle[0], edges[k, 1] - circle[1]
        away = math.sqrt(dr * dr + dc * dc)
        share = (away - circle[2]) / band
        if abs(share) >= 1.0 or abs(dr * edges[k, 2] + dc * edges[k, 3]) < ALONG * away:
            continue
        turn = (math.atan2(dr, dc) + math.pi) / (2.0 * math.pi)
        sector = int(turn * SECTORS) % SECTORS
        best[sector] = max(best[sector], weights[k] * (1.0 - share * share))
    return float(best.sum())


def _errors(fit: Floats, edges: _Edges, widest: _Edges, rivals: Floats) -> Floats:
    """Return errors of row, column and radius.

    What shading, blotches and smears do to a whole side of a rim is not in the scatter of its
    edges, but in how the circles through each half of it differ, in proportion to how much less
    such a half tells than the whole, how far taking shifts back moved
    it, how it moves with shifts that another width tells, and how far its rivals lie. Shares of
    each are those by which drawn pictures are off (`python -m benchmarks.balls.finding`).
    """
    plain = _circle(edges.seen, edges.weights, fit[:3])
    other = _circle(widest.points, widest.weights, fit[:3])
    down, right = (edges.points[:, :2] - fit[:2]).T
    halves = [
        _circle(
            edges.points,
            np.where(down * math.sin(turn) + right * math.cos(turn) > 0, edges.weights, 0.0),
            fit[:3],
        )
        for turn in (2.0 * math.pi * np.arange(HALVES) / HALVES).tolist()
    ]
    own = fit[3:6] ** 2 @ CENTRE_AND_RADIUS
    # A half of what is seen of a hidden rim is a short arc, which tells much less than the whole.
    usual = [
        (half[:3] - fit[:3]) ** 2 @ CENTRE_AND_RADIUS * own / (half[3:6] ** 2 @ CENTRE_AND_RADIUS)
        for half in halves
        if half[2] > 0 and half[3:6].all()
    ]
    square = (OF_SCATTER * fit[3:6]) ** 2
    if usual:
        square += OF_HALVES**2 * np.quantile(usual, MOST_HALVES, axis=0)
    for share, circle in ((OF_SHIFT, plain), (OF_WIDEST, other)):
        if circle[2] > 0:
            square += share**2 * ((circle[:3] - fit[:3]) ** 2 @ CENTRE_AND_RADIUS)
    if len(rivals):
        square += OF_RIVAL**2 * ((rivals - fit[:3]) ** 2 @ CENTRE_AND_RADIUS).max(axis=0)
    return np.asarray(np.sqrt(square))
