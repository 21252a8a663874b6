"""The one disc of a frame by each of the ways that the thesis compares, and by grey levels."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from analysis.arrays import Grey
from analysis.errors import ShotRefusedError
from analysis.imaging.discs import common_radius, discs, vote
from analysis.imaging.edge.edges import laplacian_of_gaussian
from analysis.imaging.edge.expansion import expanded_zero_crossings
from analysis.imaging.edge.facet import EdgePoints, edge_points
from analysis.imaging.edge.frame import EdgeSettings, find_edges, gradient_threshold, noise_sd
from analysis.imaging.outlines import Place
from analysis.imaging.shells import Circle, fit_circles
from analysis.qualification.compared_ways import adaptive_hough, canny_edges, sobel_edges
from analysis.qualification.grey_discs import fit_grey_discs

Way = Literal["pixel", "thirds", "quarters", "exact", "aht", "sobel", "canny", "photometric"]
WAYS: tuple[Way, ...] = get_args(Way)
"""Edges of the filter of width 2 at pixels, at thirds and quarters of a pixel and at the facet's
exact root, all with fuzzy shells; the adaptive Hough transform on those at quarters; ridges of
Sobel's and Canny's gradient with fuzzy shells; grey levels."""

THESIS_SIGMA_PX = 2.0
SAMPLES = {"pixel": 1, "thirds": 3, "quarters": 4, "aht": 4}
REACH_PX = 3.0
NOISE_DISTANCE_PX = 1.5
LEAST_RIM_SHARE = 0.2
SAME_SIZE = 1.05
AROUND_PX = 6.0
RIDGE_FACTOR = 2.0
"""A ridge is a maximum of noise too: its threshold is this much higher."""


def find_disc(frame: Grey, smallest_px: float, largest_px: float) -> Place:
    """Return the most complete disc of a frame, to about a pixel.

    Parameters
    ----------
    smallest_px, largest_px
        Range of its radius.

    Raises
    ------
    ShotRefusedError
        No disc shows a fifth of its rim.
    """
    settings = EdgeSettings()
    threshold = gradient_threshold(noise_sd(frame[None]), settings.sigma_px)
    edges = find_edges(frame, settings, threshold)
    radius = common_radius(edges.points, edges.shape, (smallest_px, largest_px), {1.0: 1})
    found = discs(vote(edges.points, radius, edges.shape), LEAST_RIM_SHARE, radius)
    if not found:
        raise ShotRefusedError(
            "outlines", f"no disc of {smallest_px:.0f} to {largest_px:.0f} px in radius shows"
        )
    return found[0].row, found[0].column, radius


def follow_disc(frames: Grey, smallest_px: float, largest_px: float) -> list[Place]:
    """Return the most complete disc of every frame, to about a pixel.

    The first frame tells the radius; the others have the same to a few per cent.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).

    Raises
    ------
    ShotRefusedError
        As for `find_disc`.
    """
    first = find_disc(frames[0], smallest_px, largest_px)
    near = (first[2] / SAME_SIZE, first[2] * SAME_SIZE)
    return [first, *(find_disc(frame, *near) for frame in frames[1:])]


def locate(frames: Grey, starts: list[Place], way: Way) -> list[Place]:
    """Return row, column and radius of the disc in each frame, pixels.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).
    starts
        Where the disc stands in each frame, within about a pixel.

    Raises
    ------
    ShotRefusedError
        The adaptive Hough transform finds no circle.
    """
    if way == "photometric":
        fitted = fit_grey_discs(frames, starts, shaded=True)
        return [(float(row), float(column), fitted.radius) for row, column in fitted.centres]
    noise = noise_sd(frames)
    return [
        _by_edges(_limb(_edges(frame, noise, way), start), start, way)
        for frame, start in zip(frames, starts, strict=True)
    ]


def _edges(frame: Grey, noise: float, way: Way) -> EdgePoints:
    threshold = gradient_threshold(noise, THESIS_SIGMA_PX)
    if way == "sobel":
        return sobel_edges(frame, RIDGE_FACTOR * gradient_threshold(noise, 1.0))
    if way == "canny":
        return canny_edges(frame, RIDGE_FACTOR * gradient_threshold(noise, 1.0))
    edges = laplacian_of_gaussian(frame, THESIS_SIGMA_PX)
    if way == "exact":
        return edge_points(edges, threshold)
    return expanded_zero_crossings(edges, threshold, SAMPLES[way])


def _limb(points: EdgePoints, start: Place) -> EdgePoints:
    off = np.hypot(points.row - start[0], points.column - start[1]) - start[2]
    return points.where(np.abs(off) < REACH_PX)


def _by_edges(limb: EdgePoints, start: Place, way: Way) -> Place:
    if way == "aht":
        rows, columns, radii = ((at - AROUND_PX, at + AROUND_PX) for at in start)
        found = adaptive_hough(limb, rows, columns, radii)
        if found is None:
            raise ShotRefusedError("outlines", "the adaptive Hough transform finds no circle")
        return found
    guess = Circle(*start, np.zeros((3, 3)))
    (circle,), _ = fit_circles(limb.row, limb.column, [guess], noise_distance=NOISE_DISTANCE_PX)
    return circle.row, circle.column, circle.radius
