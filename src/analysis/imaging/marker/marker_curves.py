"""Closed dark curves in the discs of a frame, and the ellipses through them, compiled."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.imaging.ellipse_shells import settle_ellipse

Indices = NDArray[np.intp]
Curves = tuple[Floats, Floats, Floats, Floats]
"""Rows, columns and unit normals (row, column) of edge points, shape (points,) each."""

INNER_RADIUS = 0.93
"""A curve reaching beyond this share of the radius is the outline's, or touches it."""
FURTHEST_CENTRE = 0.88
"""Markers nearer to the limb are too foreshortened to be measured (about 60 degrees)."""
OTHERS_PX = 1.0
LEAST_CLOSURE = 0.8
LEAST_OUTWARD = 0.7
LARGEST_SEMI_AXIS, LARGEST_SINE = 0.45, 0.5
MOST_RMS_PX = 0.4
SECTORS, LEAST_POINTS = 12, 8
TAN_30, TAN_60 = 3.0**-0.5, 3.0**0.5
ITERATIONS, SETTLED = 30, 1e-6


@part
def by_curve(labels: NDArray[np.int32]) -> tuple[Indices, Indices]:
    """Return the points' indices curve by curve, and where each curve begins; label 0 is first."""
    most = labels.max() + 1 if labels.size else 1
    first, order = np.zeros(most + 1, dtype=np.intp), np.empty(labels.size, dtype=np.intp)
    for label in labels:
        first[label + 1] += 1
    for name in range(most):
        first[name + 1] += first[name]
    following = first.copy()
    for k in range(labels.size):
        order[following[labels[k]]] = k
        following[labels[k]] += 1
    return order, first


@part
def disc_of(row: Floats, column: Floats, places: Floats, around: Floats) -> int:
    """Return the disc that holds a curve, -1 where none does or another is near.

    A curve that reaches beyond INNER_RADIUS or stays beyond FURTHEST_CENTRE is none's.
    """
    for i in range(places.shape[0]):
        inner, furthest = (INNER_RADIUS * places[i, 2]) ** 2, (FURTHEST_CENTRE * places[i, 2]) ** 2
        nearest = inner
        for k in range(row.size):
            square = (row[k] - places[i, 0]) ** 2 + (column[k] - places[i, 1]) ** 2
            nearest = min(nearest, square)
            if square > inner:
                nearest = inner
                break
        if nearest >= furthest:
            continue
        for n in range(around.shape[0]):
            reach = (around[n, 2] + OTHERS_PX) ** 2
            for k in range(row.size):
                d_r, d_c = row[k] - around[n, 0], column[k] - around[n, 1]
                if n != i and d_r * d_r + d_c * d_c < reach:
                    return -1
        return i
    return -1


@part
def closes_around_dark(curve: Curves) -> bool:
    """Tell whether a curve's points stand all around its middle with their bright sides outward."""
    row, column = curve[0].mean(), curve[1].mean()
    outward, seen = 0.0, np.zeros(SECTORS)
    for k in range(curve[0].size):
        d_r, d_c = curve[0][k] - row, curve[1][k] - column
        outward += (d_r * curve[2][k] + d_c * curve[3][k]) / max(math.hypot(d_r, d_c), 1e-9)
        steep, flat = abs(d_c), abs(d_r)
        third = 0 if steep < TAN_30 * flat else (1 if steep < TAN_60 * flat else 2)
        seen[third + (3 if d_r < 0.0 else 0) + (6 if d_c < 0.0 else 0)] = 1.0
    return outward >= LEAST_OUTWARD * curve[0].size and seen.sum() >= LEAST_CLOSURE * SECTORS


@part
def lift(ellipse: Floats, place: Floats, front: bool, lifted: Floats) -> bool:
    """Turn an ellipse's centre into a direction; false where it is too near to the limb.

    The edge of a round marker is a circle in a plane at R cos(alpha) from the sphere's centre, so
    the ellipse's centre is the marker's projection shortened by cos(alpha); the thesis's lift,
    equation (5-5), leaves that out.

    Parameters
    ----------
    lifted
        Filled with the direction in rig axes, as `ViewGeometry.direction` has it, and its cosine to
        the line of sight, shape (4,).
    """
    size = min(ellipse[2] / place[2], LARGEST_SINE)
    reach = place[2] * math.sqrt(1.0 - size * size)
    down, across = (ellipse[0] - place[0]) / reach, (ellipse[1] - place[1]) / reach
    square = down * down + across * across
    if square > FURTHEST_CENTRE * FURTHEST_CENTRE:
        return False
    facing = math.sqrt(1.0 - square)
    lifted[1], lifted[3] = across, facing
    lifted[0], lifted[2] = (down, facing) if front else (-facing, -down)
    return True


@compiled
def dark_ellipses(
    curves: Curves,
    labels: NDArray[np.int32],
    places: Floats,
    around: Floats,
    front: NDArray[np.bool_],
) -> tuple[Floats, Floats, Floats, Indices, Indices]:
    """Fit an ellipse to each curve in a disc that closes around something dark.

    Parameters
    ----------
    labels
        Of each point, shape (points,).
    places
        Row, column and known radius of the discs, pixels, shape (discs, 3).
    around
        The same discs with their own radii, then all others of the frame, shape (others, 3).
    front
        Whether the front view shows each disc, or the top view, shape (discs,).

    Returns
    -------
    Ellipses in the order of `shells.Ellipse`, shape (markers, 6), disc after disc; what `lift`
    makes of each, directions, shape (markers, 3), and facing, shape (markers,); the disc of each,
    shape (markers,); and the number up to the end of each disc, shape (discs,).
    """
    order, first = by_curve(labels)
    curve = curves[0][order], curves[1][order], curves[2][order], curves[3][order]
    most = first.size - 1
    ellipses, lifted = np.empty((most, 6)), np.empty((most, 4))
    disc, count = np.empty(most, dtype=np.intp), 0
    for name in range(1, most):
        a, b = first[name], first[name + 1]
        if b - a < LEAST_POINTS:
            continue
        i = disc_of(curve[0][a:b], curve[1][a:b], places, around)
        points = curve[0][a:b], curve[1][a:b], curve[2][a:b], curve[3][a:b]
        if i < 0 or not closes_around_dark(points):
            continue
        ellipse = ellipses[count]
        if not settle_ellipse(points[0], points[1], (ITERATIONS, SETTLED), ellipse):
            continue
        if ellipse[5] > MOST_RMS_PX or ellipse[2] >= LARGEST_SEMI_AXIS * places[i, 2]:
            continue
        if lift(ellipse, places[i], front[i], lifted[count]):
            disc[count] = i
            count += 1
    ends, kept = np.zeros(places.shape[0], dtype=np.intp), 0
    ordered, own = np.empty((count, 6)), np.empty(count, dtype=np.intp)
    directions, facing = np.empty((count, 3)), np.empty(count)
    for i in range(places.shape[0]):
        for n in range(count):
            if disc[n] == i:
                ordered[kept], own[kept] = ellipses[n], i
                directions[kept], facing[kept] = lifted[n, :3], lifted[n, 3]
                kept += 1
        ends[i] = kept
    return ordered, directions, facing, own, ends
