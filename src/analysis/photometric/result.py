"""Poses of a film in the form that the rest of the analysis takes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled
from analysis.imaging.marker.markers import FilmMarkers, Markers
from analysis.imaging.outlines import Outline
from analysis.imaging.shells import Circle
from analysis.imaging.tracks import Track
from analysis.imaging.views import View
from analysis.motion.cutting import cut_tears, notes_of, refuse_jumps
from analysis.motion.drift import CENTRE_DRIFT_PER_SIGMA2
from analysis.motion.pattern import Orientations
from analysis.motion.poses import CONSTANT_Z_SIGMA_M, Centres
from analysis.photometric.birge_ratio import birge_ratios
from analysis.photometric.follow.film import Film
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.render.camera import Optics, axes_at, disc_of, place_covariances
from analysis.photometric.render.sight import Look
from analysis.tracking import Tracking

Indices = NDArray[np.intp]


@compiled
def facing_markers(
    optics: Optics, look: Look, centres: Floats, rotations: Floats, least_facing: float
) -> tuple[Floats, Indices, Indices]:
    """Find the markers that face a view in each frame, view after view.

    Parameters
    ----------
    centres, rotations
        m and body to rig axes, shapes (frames, 3), (frames, 3, 3).
    least_facing
        Cosine to the line of sight of those that still do.

    Returns
    -------
    Row and column, semi-axes, angle and rms (0) of each ellipse, pixels, its direction in rig axes,
    and facing, shape (markers, 10); marker and view of each, shape (markers, 2); and the number up
    to the end of each frame, shape (frames,).
    """
    frames, views, most = centres.shape[0], optics.scales.shape[0], look.markers.shape[0]
    rows, count = np.zeros((frames * views * most, 10)), 0
    names, ends = np.zeros((frames * views * most, 2), dtype=np.intp), np.zeros(frames, np.intp)
    deep, wide, turned = math.cos(look.alpha), math.sin(look.alpha), np.zeros(3)
    for k in range(frames):
        for v in range(views):
            y, x, radius = disc_of(optics, v, centres[k], look.radius_m)
            axes = axes_at(optics, v, centres[k])
            for m in range(most):
                own = rows[count]
                for a in range(3):
                    own[6 + a], turned[a] = 0.0, 0.0
                for a in range(3):
                    for b in range(3):
                        own[6 + a] += rotations[k, a, b] * look.markers[m, b]
                for a in range(3):
                    for b in range(3):
                        turned[a] += axes[a, b] * own[6 + b]
                if turned[2] < least_facing:
                    continue
                own[0], own[1] = y + radius * deep * turned[0], x + radius * deep * turned[1]
                own[2], own[3] = radius * wide, radius * wide * turned[2]
                own[4], own[9] = math.atan2(turned[0], -turned[1]), turned[2]
                names[count, 0], names[count, 1] = m, v
                count += 1
        ends[k] = count
    return rows[:count].copy(), names[:count].copy(), ends


Names = NDArray[np.intp]

LEAST_FACING = 0.4
MOST_PLACE, MOST_TURN_RAD = 0.2, 0.1
"""Errors, in radii and radians, beyond which a coordinate or a turn counts as not measured."""
ORDINARY_LIMB_PX = 0.025
"""In even light outline and markers differ by up to this much and no track shows it: shadows are
beyond it now and then, gloss is by ten times. What is beyond adds to both slow errors."""


def tracking_of(film: Film, known: Appearance, times_s: Floats, gravity: float) -> Tracking:
    """Return the film's poses with discs and markers where the fitted model has them.

    The stated errors are those of the pixels, enlarged to the scatter about free flight
    (`birge_ratio.birge_ratios`); the filter width given is that of an equal slow error.
    """
    _cut_tears(film, known, times_s, gravity)
    markers = [markers_of(film, known, i) for i in (0, 1)]
    raw = centres_of(film, known, 0), centres_of(film, known, 1)
    standing = (
        orientations_of(film, known, 0, markers[0]),
        orientations_of(film, known, 1, markers[1]),
    )
    place, turn = birge_ratios(raw, standing, times_s, gravity)
    enlarged = np.sqrt(np.repeat([place, turn], 3))
    film.covariance *= np.outer(enlarged, enlarged)
    spheres = [_tracks(film, known, i) for i in (0, 1)]
    centres = [centres_of(film, known, i) for i in (0, 1)]
    turned = [orientations_of(film, known, i, markers[i]) for i in (0, 1)]
    optics = known.camera.optics
    beyond = max(known.limb_px**2 - ORDINARY_LIMB_PX**2, 0.0)
    slow_px = np.sqrt(known.slow_px**2 + beyond + film.shadow_px**2)
    radii = {
        view: (
            float(optics.scales[v] * known.spheres[0].radius_m),
            float(optics.scales[v] * known.spheres[1].radius_m),
        )
        for v, view in enumerate(known.camera.views)
    }
    return Tracking(
        spheres=(spheres[0], spheres[1]),
        markers=(markers[0][0], markers[1][0]),
        marker_angle=(known.spheres[0].alpha + known.spheres[1].alpha) / 2,
        filter_sigma_px=float(np.sqrt(slow_px / CENTRE_DRIFT_PER_SIGMA2)),
        shared_px=float(np.sqrt(known.shared_px**2 + beyond)),
        radii=radii,
        scales_px_per_m={
            v: float(s) for v, s in zip(known.camera.views, optics.scales, strict=True)
        },
        scale_sigma=known.scale_sigma,
        centres=(centres[0], centres[1]),
        orientations=(turned[0], turned[1]),
        notes=(*notes_of("a", film.left_out[0]), *notes_of("b", film.left_out[1])),
        left_out=film.left_out,
    )


def _cut_tears(film: Film, known: Appearance, times_s: Floats, gravity: float) -> None:
    """Take away the poses that belong to no free flight on either side of the contact."""
    centres = centres_of(film, known, 0), centres_of(film, known, 1)
    touch_m = sum(sphere.radius_m for sphere in known.spheres)
    off = cut_tears(centres, times_s, gravity, touch_m)
    refuse_jumps(centres, off, touch_m)
    for i, left_out in enumerate(off):
        for k, reason in left_out.items():
            film.leave_out(i, np.array([k]), reason)


def _tracks(film: Film, known: Appearance, sphere: int) -> dict[View, Track]:
    optics, views = known.camera.optics, known.camera.views
    discs, tracks = film.discs(known)[:, len(views) * sphere :], {}
    frames = np.flatnonzero(film.placed[sphere])
    centre, covariance = film.centre[sphere, frames], film.covariance[sphere, frames]
    for v, view in enumerate(views):
        track, spread = Track(view), place_covariances(optics, v, centre, covariance)
        for n, k in enumerate(frames.tolist()):
            errors = np.zeros((3, 3))
            errors[:2, :2] = spread[n]
            row, column, radius = discs[k, v].tolist()
            track.outlines[k] = Outline(Circle(row, column, radius, errors), 1.0, np.zeros((0, 2)))
        tracks[view] = track
    return tracks


def markers_of(film: Film, known: Appearance, sphere: int) -> tuple[FilmMarkers, Names]:
    """Return the markers that face a view, and the index of each in the pattern."""
    frames = np.flatnonzero(film.placed[sphere])
    rows, names, ends = facing_markers(
        known.camera.optics,
        known.looks()[sphere],
        film.centre[sphere, frames],
        film.rotation[sphere, frames],
        LEAST_FACING,
    )
    front = np.array([view is View.FRONT for view in known.camera.views])[names[:, 1]]
    every = Markers(rows[:, :6], rows[:, 6:9], rows[:, 9], front)
    return FilmMarkers(frames, ends, every), names[:, 0]


def centres_of(film: Film, known: Appearance, sphere: int) -> Centres:
    """Return the places of a sphere; one whose error is too large counts as not measured."""
    frames = np.flatnonzero(film.placed[sphere])
    position = film.centre[sphere, frames].copy()
    sigma = np.sqrt(np.einsum("nii->ni", film.covariance[sphere, frames])[:, :3])
    if len(known.camera.views) == 1:
        position[:, 2], sigma[:, 2] = 0.0, CONSTANT_Z_SIGMA_M
    unseen = sigma > MOST_PLACE * known.spheres[sphere].radius_m
    return Centres(frames, np.where(unseen, np.nan, position), np.where(unseen, np.inf, sigma))


def orientations_of(
    film: Film, known: Appearance, sphere: int, seen: tuple[FilmMarkers, Names]
) -> Orientations:
    """Return the orientations of a sphere, with its markers as `markers_of` gives them."""
    (markers, names), placed = seen, np.flatnonzero(film.placed[sphere])
    covariance = film.covariance[sphere, placed][:, 3:, 3:]
    widest = np.sqrt(np.linalg.eigvalsh(covariance)[:, -1])
    kept = widest < MOST_TURN_RAD
    frames = placed[kept]
    open_turn = (
        f"its markers leave a turn of more than {np.degrees(MOST_TURN_RAD):.0f} degrees open"
    )
    left_out = dict.fromkeys(placed[~kept].tolist(), open_turn)
    return Orientations(
        frames=frames,
        rotation=film.rotation[sphere, frames].copy(),
        covariance=covariance[kept],
        pattern=known.spheres[sphere].markers,
        matches=tuple(names[own] for own, good in zip(markers.spans(), kept, strict=True) if good),
        left_out=left_out,
    )
