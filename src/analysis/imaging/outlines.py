"""The outline of a sphere: a circle through the edge points that belong to its limb."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part
from analysis.imaging.facet import EdgePoints
from analysis.imaging.shells import NEAREST, Circle, settle_circles

Floats = NDArray[np.float64]

Place = tuple[float, float, float]
"""Row, column and radius of a disc, pixels."""
Edges = tuple[Floats, Floats, Floats, Floats]
"""Rows, columns and unit normals (row, column) of edge points, shape (points,) each."""

LIMB_REACH_PX = 3.0
"""Edge points this far from the present circle may belong to the limb."""
LEAST_ALIGNMENT = 0.95
"""Cosine between an edge's normal and the radius: a marker that cuts the limb turns the edge."""
NOISE_DISTANCES_PX = (1.5, 0.6, 0.3)
"""The noise cluster draws in as the fit settles, so a poor start does not lose the limb."""
SECTORS, LEAST_POINTS = 36, 12
MOST_ITERATIONS, SETTLED_PX = 30, 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A fitted outline.

    Attributes
    ----------
    circle
        Centre and radius in pixels with their covariance.
    coverage
        Share of 10 degree sectors of the rim that hold accepted edge points, 0 to 1.
    points
        Accepted edge points (row, column) in pixels, shape (points, 2).
    """

    circle: Circle
    coverage: float
    points: Floats


def fit_outline(
    points: EdgePoints,
    start: Place,
    others: Sequence[Place],
    keep_off_px: float,
    *,
    hold_radius: bool = False,
    blocked: NDArray[np.bool_] | None = None,
) -> Outline | None:
    """Fit one sphere's outline, starting within about 3 pixels of it.

    Parameters
    ----------
    points
        Edge points of the frame.
    start
        Where the disc is expected.
    others
        The frame's other discs: an edge point inside one of them, or within `keep_off_px` of it,
        may be its edge or be blurred by it, and is not used.
    hold_radius
        Keep the radius of `start`.
    blocked
        Edge points not to be used for another reason, shape (points,).

    Returns
    -------
    None where fewer than 12 edge points remain.
    """
    free = np.ones(len(points), dtype=np.bool_) if blocked is None else ~blocked
    discs = np.array(others, dtype=np.float64).reshape(-1, 3)
    edges = points.row, points.column, points.normal_row, points.normal_column
    place, covariance = np.array(start, dtype=np.float64), np.zeros((3, 3))
    limits = float(keep_off_px), hold_radius
    accepted, coverage = settle_outline(edges, free, discs, (place, covariance), limits)
    if coverage < 0.0:
        return None
    return Outline(
        circle=Circle(float(place[0]), float(place[1]), float(place[2]), covariance),
        coverage=coverage,
        points=np.stack([points.row[accepted], points.column[accepted]], 1),
    )


@part
def leave_others(edges: Edges, free: NDArray[np.bool_], others: Floats, keep_off_px: float) -> None:
    """Take edge points in or near other discs, shape (others, 3), out of the free ones."""
    for n in range(others.shape[0]):
        reach = others[n, 2] + keep_off_px
        for k in range(free.size):
            d_r, d_c = edges[0][k] - others[n, 0], edges[1][k] - others[n, 1]
            if d_r * d_r + d_c * d_c <= reach * reach:
                free[k] = False


@part
def limb_points(edges: Edges, free: NDArray[np.bool_], circle: Floats) -> NDArray[np.intp]:
    """Return the free points near a circle (row, column, radius) whose edge lies along it."""
    found = np.empty(free.size, dtype=np.intp)
    count = 0
    for k in range(free.size):
        if not free[k]:
            continue
        d_r, d_c = edges[0][k] - circle[0], edges[1][k] - circle[1]
        rho = max(math.hypot(d_r, d_c), NEAREST)
        if abs(rho - circle[2]) >= LIMB_REACH_PX:
            continue
        if abs(edges[2][k] * d_r + edges[3][k] * d_c) > LEAST_ALIGNMENT * rho:
            found[count] = k
            count += 1
    return found[:count]


@compiled
def settle_outline(
    edges: Edges,
    free: NDArray[np.bool_],
    others: Floats,
    outline: tuple[Floats, Floats],
    limits: tuple[float, bool],
) -> tuple[NDArray[np.intp], float]:
    """Fit an outline as `fit_outline` tells, in place.

    Parameters
    ----------
    outline
        Row, column and radius, improved, shape (3,), and their covariance, filled, shape (3, 3).
    limits
        Distance to keep off other discs, pixels, and whether the radius is held.

    Returns
    -------
    Indices of the accepted points, and the coverage; -1 where too few points remain.
    """
    place, covariance = outline
    leave_others(edges, free, others, limits[0])
    sectors = np.zeros(SECTORS)
    accepted = np.empty(0, dtype=np.intp)
    for noise in NOISE_DISTANCES_PX:
        limb = limb_points(edges, free, place)
        if limb.size < LEAST_POINTS:
            return accepted, -1.0
        u = np.empty((1, limb.size))
        shells = place.reshape(1, 3), u, covariance.reshape(1, 3, 3)
        until = noise, MOST_ITERATIONS, SETTLED_PX
        settle_circles(edges[0][limb], edges[1][limb], shells, until, limits[1])
        accepted = limb[u[0] > 0.5]
    for k in accepted:
        angle = math.atan2(edges[1][k] - place[1], edges[0][k] - place[0])
        sectors[math.floor((angle / (2 * math.pi) + 0.5) * SECTORS) % SECTORS] = 1.0
    return accepted, sectors.sum() / SECTORS
