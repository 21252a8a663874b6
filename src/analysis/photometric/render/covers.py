"""All markers of a sphere drawn into the pixels about one of its discs."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import part
from analysis.photometric.render.camera import axes_at, disc_of, nearer, own_nearness
from analysis.photometric.render.contour import LAYERS, add_cover
from analysis.photometric.render.residual import Paint
from analysis.photometric.render.sight import Sight, Stance
from analysis.photometric.render.smear import MIDDLE, at_instant, instants_of

AROUND_PX = 4
"""Surroundings of a disc that take part: they determine the background's offset."""


@part
def window(place: tuple[float, float, float], shape: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the half-open rows and columns of a disc and its surroundings within a frame."""
    reach = place[2] + AROUND_PX
    first_r = min(max(int(place[0] - reach), 0), shape[0])
    last_r = max(min(int(place[0] + reach) + 2, shape[0]), first_r)
    first_c = min(max(int(place[1] - reach), 0), shape[1])
    last_c = max(min(int(place[1] + reach) + 2, shape[1]), first_c)
    return first_r, last_r, first_c, last_c


@part
def into_view(sight: Sight, stance: Stance, view: int) -> Floats:
    """Return the rotation from body axes to row, column and towards the eye, shape (3, 3)."""
    turn, axes = np.zeros((3, 3)), axes_at(sight.optics, view, stance.centre)
    for a in range(3):
        for b in range(3):
            for k in range(3):
                turn[a, b] += axes[a, k] * stance.rotation[k, b]
    return turn


@part
def seen_from(sight: Sight, stance: Stance, view: int) -> Floats:
    """Return the markers as a view sees them: row, column, towards the eye, shape (markers, 3).

    Those of the sphere that looks the same from infinity (`camera`).
    """
    markers, turn = sight.look.markers, into_view(sight, stance, view)
    directions = np.zeros(markers.shape)
    for m in range(markers.shape[0]):
        for a in range(3):
            for k in range(3):
                directions[m, a] += turn[a, k] * markers[m, k]
    near = closeness(sight, stance, view)
    if near > 0.0:
        across = math.sqrt(1.0 - near * near)
        for m in range(markers.shape[0]):
            less = 1.0 - near * directions[m, 2]
            directions[m, 0] *= across / less
            directions[m, 1] *= across / less
            directions[m, 2] = (directions[m, 2] - near) / less
    return directions


@part
def closeness(sight: Sight, stance: Stance, view: int) -> float:
    """Return the radius of the sphere over its distance from the eye."""
    optics = sight.optics
    return sight.look.radius_m * own_nearness(optics, view) / nearer(optics, view, stance.centre)


@part
def cap_radius(sight: Sight, near: float, towards_eye: float) -> float:
    """Return a marker's angular radius: the conformal map enlarges a cap on the near side."""
    return float(sight.look.alpha * (1.0 + near * towards_eye))


@part
def cover_canvas(
    sight: Sight, stance: Stance, view: int
) -> tuple[Floats, tuple[int, int], tuple[float, float, float]]:
    """Draw the covers of all markers.

    Returns
    -------
    The canvas, shape (rows, LAYERS, columns); row and column of its first pixel; row, column and
    radius of the disc.
    """
    place = disc_of(sight.optics, view, stance.centre, sight.look.radius_m)
    shape = (sight.scene.image.shape[0], sight.scene.image.shape[1])
    first_r, last_r, first_c, last_c = window(place, shape)
    canvas = np.zeros((last_r - first_r, LAYERS, last_c - first_c))
    draw_covers(sight, stance, view, (canvas, (first_r, first_c), place))
    return canvas, (first_r, first_c), place


@part
def draw_covers(
    sight: Sight,
    stance: Stance,
    view: int,
    drawn: tuple[Floats, tuple[int, int], tuple[float, float, float]],
) -> None:
    """Add the covers of all markers to a canvas, given with its first pixel and the disc."""
    canvas, corner, place = drawn
    directions = seen_from(sight, stance, view)
    near = closeness(sight, stance, view)
    for m in range(directions.shape[0]):
        cap = (cap_radius(sight, near, directions[m, 2]), sight.look.sigma_px[view])
        add_cover(canvas, corner, place, directions[m], cap)


class Caps(NamedTuple):
    """Markers of a sphere in one view, at each instant of the exposure, the middle one's first.

    Attributes
    ----------
    places
        Row, column and radius of the disc, pixels, shape (instants, 3).
    directions
        `seen_from`, shape (instants, markers, 3).
    radii
        Angular radius of each marker as the view sees it, radians, same shape less the last axis.
    sigma_px
        Standard deviation of the blur.
    """

    places: Floats
    directions: Floats
    radii: Floats
    sigma_px: float


@part
def caps_of(sight: Sight, stance: Stance, view: int) -> Caps:
    """Return the markers of a sphere in one view."""
    look, count = sight.look, instants_of(sight)
    places, directions = np.empty((count, 3)), np.empty((count, *look.markers.shape))
    radii = np.empty((count, look.markers.shape[0]))
    for n in range(count):
        own = stance if n == 0 else at_instant(sight, stance, n)
        place = disc_of(sight.optics, view, own.centre, look.radius_m)
        places[n, 0], places[n, 1], places[n, 2] = place
        directions[n] = seen_from(sight, own, view)
        near = closeness(sight, own, view)
        for m in range(look.markers.shape[0]):
            radii[n, m] = cap_radius(sight, near, directions[n, m, 2])
    return Caps(places, directions, radii, look.sigma_px[view])


@part
def cover_of(caps: Caps, marker: int, row: int, column: int) -> float:
    """Return how much of a pixel one marker covers, over the whole exposure."""
    total, count = 0.0, caps.places.shape[0]
    for n in range(count):
        pixel = np.zeros((1, LAYERS, 1))
        place = (caps.places[n, 0], caps.places[n, 1], caps.places[n, 2])
        cap = (caps.radii[n, marker], caps.sigma_px)
        add_cover(pixel, (row, column), place, caps.directions[n, marker], cap)
        share = 1.0 if count == 1 else (MIDDLE if n == 0 else (1.0 - MIDDLE) / 2)
        total += share * pixel[0, 0, 0]
    return total


@part
def cover_canvases(
    sight: Sight, stance: Stance, view: int
) -> tuple[Floats, tuple[int, int], Floats]:
    """Draw the covers of all markers at each instant of the exposure (`smear`).

    Returns
    -------
    The canvases, the middle instant's first, shape (instants, rows, LAYERS, columns); row and
    column of their first pixel; row, column and radius of the disc, shape (instants, 3).
    """
    middle = disc_of(sight.optics, view, stance.centre, sight.look.radius_m)
    shape = (sight.scene.image.shape[0], sight.scene.image.shape[1])
    first_r, last_r, first_c, last_c = window(middle, shape)
    count = instants_of(sight)
    canvases = np.zeros((count, last_r - first_r, LAYERS, last_c - first_c))
    places = np.empty((count, 3))
    for n in range(count):
        own = stance if n == 0 else at_instant(sight, stance, n)
        place = disc_of(sight.optics, view, own.centre, sight.look.radius_m)
        places[n, 0], places[n, 1], places[n, 2] = place
        draw_covers(sight, own, view, (canvases[n], (first_r, first_c), place))
    return canvases, (first_r, first_c), places


@part
def paint_of(sight: Sight, stance: Stance, view: int, radius_px: float) -> Paint:
    """Return what a view's pixels are painted with."""
    look = sight.look
    return stance.lights[view], look.darkness, radius_px, look.sigma_px[view] ** 2
