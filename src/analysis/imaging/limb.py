"""Circles fitted to the limbs of a frame's discs, compiled (`outlines` has it in words)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.imaging.shells import sandwich, settle_circle

Indices = NDArray[np.intp]

Edges = tuple[Floats, Floats, Floats, Floats]
"""Rows, columns and unit normals (row, column) of edge points, shape (points,) each."""
Hidden = tuple[Floats, Floats]
"""Where markers may hide each limb: the parts in the image (row, column) of their directions, NaN
for none, shape (discs, markers, 2), and the cosine of the angle about them, shape (discs,)."""

LIMB_REACH_PX = 3.0
"""Edge points this far from the present circle may belong to the limb."""
DRIFT_PX = 1.0
"""Points are collected so much further about the limb, and again once it has moved by more."""
LEAST_ALIGNMENT = 0.95
"""Cosine between an edge's normal and the radius: a marker that cuts the limb turns the edge."""
NOISE_DISTANCES_PX = (1.5, 0.6, 0.3)
"""The noise cluster draws in as the fit settles, so a poor start does not lose the limb. With a
known radius the start is an outline, and the first is left out."""
SECTORS, LEAST_POINTS = 36, 12
MOST_ITERATIONS, SETTLED_PX, ROUGHLY_PX = 30, 1e-4, 1e-2
"""Steps, pixels, that are the last: of the fit, and of those that only lead to the next one."""


@part
def beside_others(row: float, column: float, discs: Floats, own: int, keep_off_px: float) -> bool:
    """Tell whether a point lies in another disc than its own, or too near to it."""
    for n in range(discs.shape[0]):
        reach = discs[n, 2] + keep_off_px
        d_r, d_c = row - discs[n, 0], column - discs[n, 1]
        if n != own and d_r * d_r + d_c * d_c <= reach * reach:
            return True
    return False


@part
def points_about(
    edges: Edges, discs: tuple[Floats, int], circle: Floats, keep_off_px: float, near: Floats
) -> int:
    """Fill the edges that may come to lie near a circle, beside no other disc; return how many.

    Parameters
    ----------
    near
        Rows, columns and unit normals, filled, shape (4, points).
    """
    row, column, normal_row, normal_column = edges
    reach = LIMB_REACH_PX + DRIFT_PX
    inner, outer, count = max(circle[2] - reach, 0.0), circle[2] + reach, 0
    for k in range(row.size):
        d_r, d_c = row[k] - circle[0], column[k] - circle[1]
        square = d_r * d_r + d_c * d_c
        # Each is put down and most are written over: a branch would be guessed wrong too often.
        near[0, count], near[1, count] = row[k], column[k]
        near[2, count], near[3, count] = normal_row[k], normal_column[k]
        count += (square >= inner * inner) & (square <= outer * outer)
    kept = 0
    for k in range(count):
        if not beside_others(near[0, k], near[1, k], discs[0], discs[1], keep_off_px):
            for a in range(4):
                near[a, kept] = near[a, k]
            kept += 1
    return kept


@part
def limb_points(
    near: Floats, circle: Floats, markers: Floats, cos_margin: float, limb: Floats
) -> int:
    """Fill the points near a circle whose edge lies along it and that no marker hides.

    Parameters
    ----------
    near
        Of `points_about`.
    limb
        Rows and columns, filled, shape (2, points).
    """
    inner, outer, count = max(circle[2] - LIMB_REACH_PX, 1e-9), circle[2] + LIMB_REACH_PX, 0
    for k in range(near.shape[1]):
        d_r, d_c = near[0, k] - circle[0], near[1, k] - circle[1]
        square = d_r * d_r + d_c * d_c
        if square <= inner * inner or square >= outer * outer:
            continue
        rho = math.sqrt(square)
        if abs(near[2, k] * d_r + near[3, k] * d_c) <= LEAST_ALIGNMENT * rho:
            continue
        seen = True
        for m in range(markers.shape[0]):
            if markers[m, 0] * d_r + markers[m, 1] * d_c > cos_margin * rho:
                seen = False
        limb[0, count], limb[1, count] = near[0, k], near[1, k]
        count += seen
    return count


@part
def moved_by(circle: Floats, before: Floats) -> float:
    """Return by how much a circle's rim has moved at most, pixels."""
    centre = math.hypot(circle[0] - before[0], circle[1] - before[1])
    return float(centre + abs(circle[2] - before[2]))


@part
def settle_limb(
    edges: Edges,
    discs: tuple[Floats, int],
    hidden: tuple[Floats, float],
    limits: tuple[float, bool],
    outline: tuple[Floats, Floats, Floats],
) -> tuple[int, float]:
    """Fit one outline; return the number of accepted points and the coverage, -1 for too few.

    Parameters
    ----------
    discs
        All of the frame, shape (discs, 3), and which is the outline's.
    outline
        Row, column and radius, improved, shape (3,); their covariance, filled, shape (3, 3); and
        accepted points, filled, shape (points, 2).
    """
    place, covariance, accepted = outline
    size, around, limb = 2 if limits[1] else 3, place.copy(), np.empty((2, edges[0].size))
    near = np.empty((4, edges[0].size + 1))
    rows, weight = np.empty((4, 0)), np.empty(0)
    count, close = 0, points_about(edges, discs, place, limits[0], near)
    for noise in NOISE_DISTANCES_PX:
        if limits[1] and noise == NOISE_DISTANCES_PX[0]:
            continue
        if moved_by(place, around) > DRIFT_PX:
            around[:] = place
            close = points_about(edges, discs, place, limits[0], near)
        count = limb_points(near[:, :close], place, hidden[0], hidden[1], limb)
        if count < LEAST_POINTS:
            return 0, -1.0
        last = SETTLED_PX if noise == NOISE_DISTANCES_PX[-1] else ROUGHLY_PX
        until = noise, MOST_ITERATIONS, last
        rows, weight = settle_circle(limb[0, :count], limb[1, :count], place, size, until)
    sandwich(rows, weight, size, covariance)
    sectors, kept = np.zeros(SECTORS), 0
    for n in range(count):
        # A weight is the square of a membership; the limb's own is the larger one.
        if weight[n] <= 0.25:
            continue
        accepted[kept, 0], accepted[kept, 1] = limb[0, n], limb[1, n]
        kept += 1
        angle = math.atan2(limb[1, n] - place[1], limb[0, n] - place[0])
        sectors[math.floor((angle / (2 * math.pi) + 0.5) * SECTORS) % SECTORS] = 1.0
    return kept, sectors.sum() / SECTORS


@compiled
def settle_outlines(
    edges: Edges,
    outlines: tuple[Floats, Floats],
    discs: Floats,
    hidden: Hidden,
    limits: tuple[float, bool],
) -> tuple[Floats, Indices, Floats]:
    """Fit several outlines of a frame as `outlines.fit_outlines` tells.

    Parameters
    ----------
    outlines
        Rows, columns and radii, improved, shape (outlines, 3), and their covariances, filled,
        shape (outlines, 3, 3).

    Returns
    -------
    Accepted points of all, shape (points, 2), where each outline's end, and the coverages; -1
    where too few points remain.
    """
    places, covariance = outlines
    most = places.shape[0]
    accepted, ends = np.empty((most * edges[0].size, 2)), np.zeros(most, dtype=np.intp)
    coverage, count = np.empty(most), 0
    for i in range(most):
        own = places[i], covariance[i], accepted[count:]
        kept, coverage[i] = settle_limb(
            edges, (discs, i), (hidden[0][i], hidden[1][i]), limits, own
        )
        count += kept
        ends[i] = count
    return accepted[:count].copy(), ends, coverage
