"""From outlines and markers to the first film and the first guess of how the spheres look."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey
from analysis.errors import ShotRefusedError
from analysis.imaging.marker.markers import FilmMarkers
from analysis.imaging.views import View
from analysis.motion.rotation import rotation_matrix, rotation_vector
from analysis.photometric.follow.film import Film
from analysis.photometric.follow.visibility import drop_unseen
from analysis.photometric.learn.appearance import (
    LONE_SHARED_PX,
    PRIOR_SLOW_PX,
    Appearance,
    Sphere,
)
from analysis.photometric.learn.relief import nodes_for
from analysis.photometric.learn.shared import BENDS
from analysis.photometric.render.camera import Camera, camera_of
from analysis.photometric.render.shading import HARMONICS
from analysis.setup import Setup
from analysis.tracking import Tracking

FACING = 0.7
AROUND, POINTS = 2.2, 12
"""Radii of a marker at which the surface beside it is looked at, and in how many places."""


def first_darkness(frames: Grey, markers: tuple[FilmMarkers, ...]) -> float | None:
    """Return the share of the light that the middles of the markers lack, the median of all.

    None where no marker faces a view. Blur makes it less than it is on spheres of a few pixels.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).
    markers
        As seen on each sphere.
    """
    shares = np.concatenate([_shares(frames, own) for own in markers])
    return float(np.median(shares)) if shares.size else None


def _shares(frames: Grey, markers: FilmMarkers) -> Floats:
    facing = markers.every.facing > FACING
    frame = markers.frames[markers.frame_of_each()[facing]]
    row, column, wide = markers.every.ellipses[facing, :3].T
    middle = [
        _grey(frames, frame, row + down, column + across)
        for down, across in product((-1, 0, 1), repeat=2)
    ]
    beside = [
        _grey(
            frames, frame, row + AROUND * wide * np.sin(turn), column + AROUND * wide * np.cos(turn)
        )
        for turn in np.arange(POINTS) * (2 * np.pi / POINTS)
    ]
    surface = np.median(beside, axis=0)
    return np.asarray(1.0 - np.mean(middle, axis=0) / np.maximum(surface, 1.0))


def _grey(frames: Grey, frame: NDArray[np.intp], row: Floats, column: Floats) -> Floats:
    """Return the grey levels of the nearest pixels, at the border those of the frame's rim."""
    last = frames.shape[1] - 1, frames.shape[2] - 1
    y = np.clip(np.rint(row), 0, last[0]).astype(np.intp)
    x = np.clip(np.rint(column), 0, last[1]).astype(np.intp)
    return frames[frame, y, x].astype(np.float64)


MOST_FULL = 0.5
"""Share of the bright pixels. A highlight fills a few percent; with half of the discs cut off the
limb shifts by some tenths of a pixel, and the residuals do not show it."""


def refuse_full(frames: Grey) -> None:
    """Refuse frames in which most of what is bright has one and the same grey level.

    Raises
    ------
    ShotRefusedError
        With the share and the grey level.
    """
    counts = np.bincount(np.rint(frames).astype(np.uint8).ravel(), minlength=256)
    top = int(np.flatnonzero(counts)[-1])
    middle = int(np.searchsorted(counts.cumsum(), frames.size / 2))
    bright = int(counts[(top + middle) // 2 + 1 :].sum())
    share = counts[top] / bright if bright else 0.0
    if share > MOST_FULL:
        raise ShotRefusedError(
            "frames",
            f"{100 * share:.0f} % of the bright pixels are full at grey level {top}, "
            f"{100 * MOST_FULL:.0f} % are allowed; take less light or a shorter exposure",
        )


FIRST_BLUR_PX = 0.85
FIRST_DARKNESS, FAINT = 0.6, 0.4
"""Of markers in ink; those that lack less of the light are taken as they are seen."""
SMALLEST_ALPHA = 0.06
LEAST_DARKNESS = 0.1
"""Fainter markers cannot be distinguished from smudges of the surface."""
EDGE_BIAS_PX = 0.5
"""Strong light from one side moves an edge by up to this much."""
BEYOND = 3
"""Frames that a track is carried on beyond its ends."""
LEAST_TURNED = 2
"""Frames with an orientation, for a rate to carry it on."""


def first_film(
    frames: Grey, times_s: Floats, tracking: Tracking, setup: Setup
) -> tuple[Film, Appearance]:
    """Return a film with the tracking's poses, gaps filled, and a first guess of the spheres.

    Raises
    ------
    ShotRefusedError
        Most of the light is beyond what the sensor holds, a sphere is seen to turn in too few
        frames, or its height is seen in none.
    """
    refuse_full(frames)
    for name, turned in zip("ab", tracking.orientations, strict=True):
        if len(turned.frames) < LEAST_TURNED:
            found = f"sphere {name} has an orientation in {len(turned.frames)} frames"
            raise ShotRefusedError("markers", f"{found}, {LEAST_TURNED} are needed to learn it")
    views = tuple(tracking.scales_px_per_m)
    camera = camera_of(setup.camera, np.array([tracking.scales_px_per_m[v] for v in views]))
    film = Film.blank(frames, len(views), times_s, setup.environment.gravity_m_per_s2)
    for i in (0, 1):
        centres = tracking.centres[i]
        for axis in range(3):
            seen = np.isfinite(centres.position[:, axis])
            if not seen.any():
                found = f"sphere {'ab'[i]} shows enough of its limb in no frame of the top view"
                raise ShotRefusedError("outlines", found)
            own = centres.frames[seen]
            film.centre[i, :, axis] = _carried(times_s, own, centres.position[seen, axis])
        turned = tracking.orientations[i]
        film.rotation[i] = _turned_on(times_s, turned.frames, turned.rotation)
        first = max(int(centres.frames[0]) - BEYOND, 0)
        film.placed[i, first : int(centres.frames[-1]) + BEYOND + 1] = True
    camera = camera.with_origins(_agreeing_origins(camera, tracking, film))
    radii = np.array([body.diameter_m / 2 for body in setup.spheres])
    drop_unseen(film, camera.optics, radii)
    shading = np.zeros((len(views), len(HARMONICS)))
    shading[:, 0] = float(np.percentile(frames, 95))
    alpha = max(tracking.marker_angle, SMALLEST_ALPHA)
    darkness = _first_guess(first_darkness(frames, tracking.markers))
    radius = float(camera.optics.scales[0] * setup.spheres[0].diameter_m / 2)
    reliefs = np.zeros((len(views), nodes_for(radius), nodes_for(radius)))
    spheres = [
        Sphere(body.diameter_m / 2, turned.pattern, alpha, darkness, shading, reliefs)
        for body, turned in zip(setup.spheres, tracking.orientations, strict=True)
    ]
    known = Appearance(
        camera=camera,
        sigma_px=np.full(len(views), FIRST_BLUR_PX),
        spheres=(spheres[0], spheres[1]),
        scale_sigma=tracking.scale_sigma,
        camera_sigma=(math.inf,) * (len(views) + BENDS),
        limb_px=0.0,
        pattern_sigma_rad=math.inf,
        films=1,
        slow_px=PRIOR_SLOW_PX,
        shared_px=LONE_SHARED_PX,
        smear_px2=np.zeros(len(views)),
    )
    return film, known


def _first_guess(darkness: float | None) -> float:
    """Return the darkness to begin with, where the markers seem to have this one."""
    if darkness is None or darkness > FAINT:
        return FIRST_DARKNESS
    return max(darkness, LEAST_DARKNESS)


def _carried(times_s: Floats, known: NDArray[np.intp], values: Floats) -> Floats:
    """Interpolate a coordinate to all frames and carry it on straight beyond its ends."""
    whole = np.interp(times_s, times_s[known], values)
    for end, step in ((0, 1), (-1, -1)):
        if len(known) < 2:
            break
        a, b = known[end], known[end + step]
        slope = (values[end + step] - values[end]) / (times_s[b] - times_s[a])
        beyond = times_s < times_s[a] if end == 0 else times_s > times_s[a]
        whole[beyond] = values[end] + slope * (times_s[beyond] - times_s[a])
    return whole


def _turned_on(times_s: Floats, known: NDArray[np.intp], rotation: Floats) -> Floats:
    """Carry orientations to all frames at the rate between the nearest known ones."""
    whole = np.empty((len(times_s), 3, 3))
    for k, time in enumerate(times_s):
        near = int(np.abs(times_s[known] - time).argmin())
        other = (
            near + 1
            if near + 1 < len(known) and (time > times_s[known[near]] or near == 0)
            else near - 1
        )
        gap = times_s[known[other]] - times_s[known[near]]
        rate = rotation_vector(rotation[other] @ rotation[near].T) / gap
        whole[k] = rotation_matrix(rate * (time - times_s[known[near]])) @ rotation[near]
    return whole


def _agreeing_origins(camera: Camera, tracking: Tracking, film: Film) -> Floats:
    """Shift the top view's columns so that both views agree on Y.

    Origins that agree within what shading does to edges are left as they were stated.
    """
    origins = camera.optics.origins.copy()
    if View.TOP not in camera.views:
        return origins
    v = camera.views.index(View.TOP)
    gaps = [
        outline.circle.column - origins[v, 1] - camera.optics.scales[v] * film.centre[i, k, 1]
        for i, sphere in enumerate(tracking.spheres)
        for k, outline in sphere[View.TOP].outlines.items()
    ]
    gap = float(np.median(gaps))
    if abs(gap) > EDGE_BIAS_PX:
        origins[v, 1] += gap
    return origins
