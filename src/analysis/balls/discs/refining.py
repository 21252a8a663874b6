"""The circle of a found disc from the edges of the whole picture, and how far off it may be."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.discs.gradient import Gradient, gradient
from analysis.balls.discs.judging import LEAST_SECTORS, PASSES, fit_circle

Flags = NDArray[np.bool_]

CORRELATED = 2.5
"""By how much neighbouring edge points, which share what noise the filter saw, enlarge errors."""
RIM_PX, RIM_RADII = 0.01, 0.001
"""What shading leaves of any centre's error, px and radii (python -m benchmarks.balls.finding)."""
WIDER = 2.0
"""Width of edges, in that of those that count, by which a circle moves where a rim is not sharp."""
PARTS, STRONG = 16, 8
"""Of a rim, and how many of those with the strongest edges are fitted by themselves."""
NEAR_RADII, NEAR_PX = 0.03, 0.8
"""From a circle to its edges."""
CENTRE_AND_RADIUS = np.array([[0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.0, 0.0, 1.0]])
"""Mean square of the changes of row and column, for both; that of the radius."""
REACH_RADII, REACH_PX, LEAST_PX = 1.25, 6.0, 8


def refined(values: Singles, place: Floats, sigma_px: float) -> tuple[Floats, Floats] | None:
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
    reach = math.ceil(REACH_RADII * place[2] + REACH_PX)
    top, left = (max(0, int(middle) - reach) for middle in place[:2])
    bottom, right = (int(middle) + reach + 1 for middle in place[:2])
    window = np.ascontiguousarray(values[top:bottom, left:right])
    if min(window.shape[:2]) < LEAST_PX:
        return None
    corner = np.array([top, left, 0.0])
    sharp = gradient(window, sigma_px)
    fit = _circle(sharp.edges, place - corner)
    moved = math.hypot(*(fit[:2] - (place - corner)[:2]))
    if fit[2] <= 0 or fit[6] < LEAST_SECTORS or moved > 0.1 * place[2] + 1.0:
        return None
    blunt = gradient(window, WIDER * sigma_px).edges
    others = (
        _circle(blunt, fit[:3]),
        _circle(sharp.edges, fit[:3], bands=1),
        _circle(sharp.edges, fit[:3], alive=_strong(sharp, fit)),
    )
    return fit[:3] + corner, _with_changes(fit, others)


def with_rim(sigmas: Floats, radius: float) -> Floats:
    """Return errors with what shading leaves of those of any disc."""
    return np.asarray(np.hypot(sigmas, RIM_PX + RIM_RADII * radius))


def _circle(
    edges: Singles, place: Floats, bands: int = len(PASSES), alive: Flags | None = None
) -> Floats:
    every = np.ones(len(edges), np.bool_) if alive is None else alive
    return fit_circle(edges, every, np.ascontiguousarray(place), bands)


def _strong(found: Gradient, fit: Floats) -> Flags:
    """Return which edges lie where the rim has its strongest ones: in half of its parts."""
    points = found.edges[:, :2].astype(np.float64)
    off = points - fit[:2]
    near = np.abs(np.hypot(*off.T) - fit[2]) < max(NEAR_PX, NEAR_RADII * fit[2])
    angles = np.arctan2(off[:, 0], off[:, 1]) + np.pi
    parts = np.floor(angles / (2 * np.pi) * PARTS).astype(np.intp) % PARTS
    sizes = found.field[0][tuple(np.rint(points).astype(np.intp).T)]
    middle = [float(np.median(sizes[own])) if own.any() else 0.0 for own in _each(parts, near)]
    return np.isin(parts, np.argsort(middle)[-STRONG:])


def _each(parts: NDArray[np.intp], near: Flags) -> list[Flags]:
    return [near & (parts == part) for part in range(PARTS)]


def _with_changes(fit: Floats, others: Sequence[Floats]) -> Floats:
    """Return errors of row, column and radius that hold how a circle changes with its edges.

    Shading, blotches and smears move the edges of a whole side of a rim: the scatter of edges about
    the circle does not tell, but edges of another width, those further off it, and the strongest
    alone move otherwise. The largest of these changes counts, in whichever direction.
    """
    changes = [other[:3] - fit[:3] for other in others if other[2] > 0]
    square = (np.array([np.zeros(3), *changes]) ** 2) @ CENTRE_AND_RADIUS
    return np.asarray(np.sqrt((CORRELATED * fit[3:6]) ** 2 + square.max(axis=0)))
