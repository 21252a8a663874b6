"""The dark markers on a sphere without their edges: places darker than all that surrounds them.

Where a highlight stands beside a marker, or a marker is only a few pixels wide, its edge does not
close. A grey closing (the largest, then the least grey level in a window: J. Serra, Image Analysis
and Mathematical Morphology, 1982, chapter 12) fills dark places narrower than its window, and
leaves shading, shadows and highlights as they are. What it fills is a marker.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey, Singles, as_singles
from analysis.compiled import compiled
from analysis.imaging.marker.marker_curves import FURTHEST_CENTRE
from analysis.imaging.marker.markers import Markers, SeenDisc, joined
from analysis.imaging.outlines import Place
from analysis.imaging.views import View, ViewGeometry

LEAST_SHARE = 1e-3
"""Of smoothing that falls on free pixels; divided by no less."""


@compiled
def free_light(
    frame: Singles, corner: tuple[int, int], discs: Floats, free: Singles, light: Singles
) -> bool:
    """Mark the free pixels of a patch and take their light; tell whether there are any.

    Parameters
    ----------
    corner
        Row and column of the patch's first pixel in the frame.
    discs
        Row, column and radius: free is what lies in the first and in none of the others.
    free, light
        Filled with 1 or 0, and with grey levels or 0, shape (rows, columns).
    """
    some = False
    for i in range(free.shape[0]):
        for j in range(free.shape[1]):
            y, x, own = corner[0] + i, corner[1] + j, True
            for n in range(discs.shape[0]):
                d_r, d_c = y - discs[n, 0], x - discs[n, 1]
                own = own and (d_r * d_r + d_c * d_c < discs[n, 2] * discs[n, 2]) == (n == 0)
            free[i, j] = 1.0 if own else 0.0
            light[i, j] = frame[y, x] if own else 0.0
            some = some or own
    return some


@compiled
def over_share(light: Singles, share: Singles, free: Singles) -> None:
    """Divide smoothed light by the share of it that free pixels have; 0 where none is."""
    for i in range(light.shape[0]):
        for j in range(light.shape[1]):
            level = light[i, j] / max(share[i, j], np.float32(LEAST_SHARE))
            light[i, j] = level if free[i, j] > 0.0 else np.float32(0.0)


@compiled
def lacking(
    surface: Singles,
    smooth: Singles,
    free: Singles,
    least: tuple[float, float],
    dark: NDArray[np.uint8],
) -> None:
    """Leave of a closed surface what it lies above the light, where that is enough; else 0.

    Parameters
    ----------
    least
        Share of the surface, and grey levels.
    dark
        Filled with 1 where it is.
    """
    for i in range(surface.shape[0]):
        for j in range(surface.shape[1]):
            lack = surface[i, j] - smooth[i, j]
            enough = free[i, j] > 0.0 and lack > max(least[0] * surface[i, j], least[1])
            dark[i, j] = 1 if enough else 0
            surface[i, j] = lack if enough else np.float32(0.0)


@compiled
def weigh_places(missing: Singles, names: NDArray[np.int32], count: int) -> Floats:
    """Return size, missing light, and its mean row and column of each named place.

    Parameters
    ----------
    names
        Of each pixel's place, 0 for none.
    count
        Of names, with 0.

    Returns
    -------
    Shape (count, 4).
    """
    places = np.zeros((count, 4))
    for i in range(names.shape[0]):
        for j in range(names.shape[1]):
            own = places[names[i, j]]
            own[0] += 1.0
            own[1] += missing[i, j]
            own[2] += missing[i, j] * i
            own[3] += missing[i, j] * j
    for n in range(1, count):
        places[n, 2] /= places[n, 1]
        places[n, 3] /= places[n, 1]
    return places


SMOOTH_PX = 0.7
WIDEST, BLURRED_PX = 0.5, 2.6
"""Width of the window: that of a marker of 0.25 radians, in radii, and what blur adds to it."""
LIMB_PX = 1.5
"""So far inward the blur carries what lies beyond the limb, which may be brighter."""
KEEP_OFF_PX = 2.0
LEAST_DARKNESS, FAINT_DARKNESS = 0.25, 0.08
"""Share of the light that is missing: the middle of a marker in ink lacks 0.5 to 0.9 of it. Less
than the first are smudges and shading too; the second is for spheres that show nothing else."""
BEYOND_NOISE = 2.5
"""In units of a pixel's noise, of which smoothing leaves 0.4; the largest of a window lies 1 above
the mean."""
SMALLEST = 0.004
"""Size of a place as a share of the disc: one of 0.16 radians has 0.025 at the middle."""
FEWEST_PX = 4


def find_dark_places(
    frame: Grey,
    discs: Sequence[SeenDisc],
    others: Sequence[Place] = (),
    *,
    noise: float,
    least_darkness: float = LEAST_DARKNESS,
) -> tuple[Markers, NDArray[np.intp]]:
    """Find the dark places in the discs of one frame.

    Parameters
    ----------
    others
        Further discs of the frame. A place that reaches into another disc may be of either sphere
        and is left out.
    noise
        Standard deviation of a pixel, grey levels.
    least_darkness
        Share of the light that is missing at least.

    Returns
    -------
    The dark places of all discs, one disc after the other, and the number up to the end of each,
    shape (discs,).
    """
    found = []
    for n, disc in enumerate(discs):
        beside = [other.place() for m, other in enumerate(discs) if m != n]
        limits = least_darkness, noise
        found.append(_in_disc(frame, disc, [*beside, *others], limits))
    return joined(found), np.cumsum([len(own) for own in found], dtype=np.intp)


def _in_disc(
    frame: Grey, disc: SeenDisc, others: Sequence[Place], least: tuple[float, float]
) -> Markers:
    radius_px = disc.radius_px
    place = *disc.place()[:2], radius_px
    rows, columns = _patch(frame.shape, place)
    beside = [(row, column, radius + KEEP_OFF_PX) for row, column, radius in others]
    discs = np.array([(*place[:2], radius_px - LIMB_PX), *beside])
    free, light = np.empty((2, rows.stop - rows.start, columns.stop - columns.start), np.float32)
    corner = rows.start, columns.start
    if not free_light(as_singles(frame), corner, discs, free, light):
        return joined([])
    missing, dark = _missing(free, light, radius_px, least)
    count, names = cv2.connectedComponents(dark)
    weighed = weigh_places(missing, np.asarray(names, dtype=np.int32), count)
    smallest = max(FEWEST_PX, SMALLEST * math.pi * radius_px**2)
    found = []
    for area, _, row, column in weighed[1:].tolist():
        if area < smallest:
            continue
        down, across = row + corner[0] - place[0], column + corner[1] - place[1]
        marker = _lifted((down / radius_px, across / radius_px), area, place)
        if marker is not None:
            found.append(marker)
    return _directed(np.array(found).reshape(-1, 9), disc.geometry)


def _patch(shape: tuple[int, ...], place: Place) -> tuple[slice, slice]:
    """Return the rows and columns of a disc within a frame."""
    first = [max(math.floor(middle - place[2]), 0) for middle in place[:2]]
    last = [
        max(min(math.ceil(middle + place[2]) + 1, size), start)
        for middle, size, start in zip(place[:2], shape, first, strict=True)
    ]
    return slice(first[0], last[0]), slice(first[1], last[1])


def _missing(
    free: Singles, light: Singles, radius_px: float, least: tuple[float, float]
) -> tuple[Singles, NDArray[np.uint8]]:
    """Return the light that narrow dark places lack, grey levels, 0 elsewhere, and where it does.

    All that is not free counts as dark: a dark side between a bright one and a brighter
    background is no marker.

    Parameters
    ----------
    least
        Share of the light that is missing, and the noise of a pixel.
    """
    smooth, share = (
        np.asarray(cv2.GaussianBlur(x, (0, 0), SMOOTH_PX), np.float32) for x in (light, free)
    )
    over_share(smooth, share, free)
    surface = cv2.morphologyEx(smooth, cv2.MORPH_CLOSE, _window(radius_px))
    missing, dark = np.asarray(surface, np.float32), np.empty(free.shape, np.uint8)
    lacking(missing, smooth, free, (least[0], BEYOND_NOISE * least[1]), dark)
    return missing, dark


@lru_cache(maxsize=8)
def _window(radius_px: float) -> NDArray[np.uint8]:
    width = 2 * round((WIDEST * radius_px + BLURRED_PX) / 2) + 1
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width)), np.uint8)


def _lifted(centre: tuple[float, float], area: float, place: Place) -> tuple[float, ...] | None:
    """Return a dark place's ellipse and its direction in the view's axes (row, column, eye).

    As for edges, a marker's middle is shortened by the cosine of its angular radius.
    """
    flat = math.hypot(*centre)
    size = math.sqrt(area / math.pi) / place[2] / max(1.0 - flat**2, 0.1) ** 0.25
    deep = math.sqrt(1.0 - min(size, 0.5) ** 2)
    down, across = centre[0] / deep, centre[1] / deep
    if math.hypot(down, across) > FURTHEST_CENTRE:
        return None
    facing = math.sqrt(1.0 - down**2 - across**2)
    row, column = place[0] + place[2] * centre[0], place[1] + place[2] * centre[1]
    wide, angle = size * place[2], math.atan2(down, -across)
    return (row, column, wide, wide * facing, angle, 0.0, down, across, facing)


def _directed(found: Floats, geometry: ViewGeometry) -> Markers:
    """Turn the rows of `_lifted` into markers."""
    facing = found[:, 8]
    front = np.full(len(found), geometry.view is View.FRONT)
    return Markers(found[:, :6], geometry.direction(found[:, 6], found[:, 7]), facing, front)
