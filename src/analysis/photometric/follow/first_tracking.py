"""The first look at spheres that are not known: poses by edges, good enough to begin to render.

Coarser than tracking by edges alone (`analysis.tracking.track_spheres`) and more tolerant. It works
where a sphere shows a third of its limb, before a scene with edges of its own, beside
highlights, and where markers are faint or a few pixels wide.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey, Singles, as_singles
from analysis.errors import ShotRefusedError
from analysis.imaging.edge.frame import EdgeSettings, FilmEdges, gradient_threshold, noise_sd
from analysis.imaging.film_discs import FilmDiscs
from analysis.imaging.film_following import FilmCurves
from analysis.imaging.marker.dark_places import FAINT_DARKNESS, LEAST_DARKNESS
from analysis.imaging.marker.markers import FilmMarkers, film_markers
from analysis.imaging.radii import FilterBias, filter_bias, shared_radii
from analysis.imaging.views import View, view_geometries
from analysis.motion.drift import CENTRE_DRIFT_PER_SIGMA2
from analysis.motion.pattern import Orientations
from analysis.motion.poses import Centres
from analysis.motion.sightings import markers_by_darkness
from analysis.motion.split import split_at_contact
from analysis.photometric.birge_ratio import scatter_ratio
from analysis.setup import Setup
from analysis.tracking import (
    Sighting,
    Tracking,
    film_edges,
    followed_discs,
    refined_discs,
    refuse_repeats,
    tracking_of,
)

STILL_SHARE = 1 / 3
"""Of the frames: a sphere may cover the scene behind it in all others."""
SMOOTHED_PX = 0.7
LEAST_NOISES = 5.0
CLOSED_PX = 7
"""Gaps where a sphere is by chance as bright as the scene behind it."""
SOFTENED_PX = 1.0
BRIGHT = 200.0


def silhouettes(frames: Grey, noise_grey: float) -> NDArray[np.uint8]:
    """Return pictures that are bright where the frames differ from what stands still.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).
    noise_grey
        Standard deviation of a pixel.
    """
    still = still_scene(frames)
    # Smoothed over more than its own width, noise is that much smaller.
    noise = noise_grey / max(1.0, np.sqrt(4 * np.pi) * SMOOTHED_PX)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (CLOSED_PX, CLOSED_PX))
    seen = np.empty(frames.shape, np.uint8)
    for k, frame in enumerate(frames):
        off = cv2.GaussianBlur(frame.astype(np.float32) - still, (0, 0), SMOOTHED_PX)
        other = (np.abs(off) > LEAST_NOISES * noise).astype(np.uint8)
        closed = cv2.morphologyEx(other, cv2.MORPH_CLOSE, kernel)
        opened = cv2.morphologyEx(closed, cv2.MORPH_OPEN, kernel)
        soft = cv2.GaussianBlur(opened.astype(np.float32) * BRIGHT, (0, 0), SOFTENED_PX)
        seen[k] = np.rint(soft).astype(np.uint8)
    return seen


def still_scene(frames: Grey) -> NDArray[np.float32]:
    """Return the grey level that each pixel shows most often, shape (rows, columns).

    The mean of the narrowest interval that holds a third of a pixel's values (the shorth's
    relative): a median is wrong where a slow sphere covers a pixel in most frames.
    """
    ordered = np.sort(frames, axis=0).astype(np.float32)
    held = max(2, round(STILL_SHARE * len(frames)))
    if held >= len(frames):
        return np.asarray(np.median(ordered, axis=0), dtype=np.float32)
    first = np.argmin(ordered[held - 1 :] - ordered[: -held + 1], axis=0)
    within = np.take_along_axis(ordered, first[None] + np.arange(held)[:, None, None], axis=0)
    return np.asarray(within.mean(axis=0), dtype=np.float32)


LEFT_BY_THE_LENS = 0.5
"""Of a shift by shading that two filters have taken out, this share stays: the lens widens edges as
the filter does, (0.8 / 1.2)^2 as much, and no filter shows it."""
LEAST_COVERAGE = 0.3
MOSTLY_TURNED = 0.8
"""Share of a sphere's frames with an orientation from which no fainter markers are looked for."""
UNCUT = 2.0
"""Slow error of an outline with the stretches that markers cut, over that of one without them:
spheres of 10 px radius in one view were off by 0.1 to 0.2 px (trial), 0.05 px is the other."""
LEAST_HEIGHTS = 2
"""Frames of a flight with a height, for its velocity along the mirror's rows."""
MOST_DRIFT = 0.2
"""Of the speed before the camera: four of the standard deviations of what one view leaves open of
the velocity in depth (`collision.unseen_depth`)."""
UNCUT_OF_PX = 20.0
"""Radius from which on that holds. Of a smaller sphere a marker's blurred edge takes a longer
stretch: one of 7 px radius drifts by 0.3 px in a flight (trial)."""
LIMB_SCALE_SIGMA = 0.005
"""Light from one side makes a radius 0.3 to 0.8 % too small where no markers contradict it."""


def first_tracking(frames: Grey, times_s: Floats, setup: Setup) -> Tracking:
    """Find both spheres in every frame that shows them, and their markers as dark places.

    Raises
    ------
    ShotRefusedError
        With the step, the frame and the reason.
    """
    frames, settings = as_singles(frames), EdgeSettings()
    noise, discs, curves, radii = _outlined(frames, times_s, setup, settings)
    views = view_geometries(setup.camera)

    def marked(discs: FilmDiscs, darkness: float) -> Sighting:
        seen = markers_by_darkness(frames, views, discs, radii, (darkness, noise))
        return Sighting.of(seen, radii, times_s)

    rough, darkness = _best_marked(discs, marked)
    refined = refined_discs(discs, curves, rough, setup, settings)
    # Dark places depend on where the limb is.
    seen = marked(refined, darkness)
    return tracking_of(refined, seen, setup, settings, filter_bias(frames, discs, settings, noise))


def _best_marked(
    discs: FilmDiscs, marked: Callable[[FilmDiscs, float], Sighting]
) -> tuple[Sighting, float]:
    """Return the markers and the least darkness by which most frames have an orientation.

    Faint places are asked for where plain ones leave many frames open: of a marker a few pixels
    wide the blur leaves a third of its darkness. Smudges are among them, so plain ones go first.

    Raises
    ------
    ShotRefusedError
        Neither gives any, for the reason of plain ones.
    """
    refusals, found = list[ShotRefusedError](), list[tuple[float, Sighting, float]]()
    for darkness in (LEAST_DARKNESS, FAINT_DARKNESS):
        try:
            sighting = marked(discs, darkness)
        except ShotRefusedError as own:
            refusals.append(own)
            continue
        share = min(
            len(turned.frames) / max(len(seen.frames), 1)
            for turned, seen in zip(sighting.orientations, sighting.markers, strict=True)
        )
        if share >= MOSTLY_TURNED:
            return sighting, darkness
        found.append((share, sighting, darkness))
    if not found:
        raise refusals[0]
    _, sighting, darkness = max(found, key=lambda own: own[0])
    return sighting, darkness


def track_unmarked(frames: Grey, times_s: Floats, setup: Setup, reason: str) -> Tracking:
    """Measure where both spheres are by their outlines alone: spheres without markers have no spin.

    Their radii are held in the ratio of the diameters, and centres are those of the edge filter.
    Markers too few for an orientation shift an outline all the same while they cross it.

    Parameters
    ----------
    reason
        Why no orientation is known, for the notes.

    Raises
    ------
    ShotRefusedError
        With the step, the frame and the reason.
    """
    frames, settings = as_singles(frames), EdgeSettings()
    noise, discs, curves, radii = _outlined(frames, times_s, setup, settings)
    views = view_geometries(setup.camera)
    dark = markers_by_darkness(frames, views, discs, radii, (LEAST_DARKNESS, noise))
    unmarked = Orientations.none()
    seen = Sighting((film_markers({}), film_markers({})), (unmarked, unmarked), radii)
    refined = refined_discs(discs, curves, seen, setup, settings)
    bias = filter_bias(frames, discs, settings, noise, len(frames))
    moved = replace(refined, circles=refined.circles.copy())
    moved.circles[..., :2] -= bias.place[:, :, None]
    tracking = tracking_of(moved, seen, setup, settings, bias, least_px=0.0)
    gravity = setup.environment.gravity_m_per_s2
    heights = _hidden_heights(tracking.centres, times_s, gravity)
    if heights:
        a, b = (own.without_depth() for own in tracking.centres)
        tracking = replace(tracking, centres=(a, b))
    slow_px = _unlike_px(bias)
    if any(_is_marked(own) for own in dark):
        smallest_px = min(min(own) for own in radii.values())
        cut_px = UNCUT * CENTRE_DRIFT_PER_SIGMA2 * settings.sigma_px**2
        cut_px *= max(1.0, UNCUT_OF_PX / smallest_px)
        slow_px = float(np.hypot(slow_px, cut_px))
    ratio = scatter_ratio(tracking.centres, times_s, gravity)
    a, b = (replace(own, sigma=np.sqrt(ratio) * own.sigma) for own in tracking.centres)
    return replace(
        tracking,
        centres=(a, b),
        filter_sigma_px=float(np.sqrt(slow_px / CENTRE_DRIFT_PER_SIGMA2)),
        notes=(f"measured by outlines alone, spins are open: {reason}", *heights),
        scale_sigma=tracking.scale_sigma and LIMB_SCALE_SIGMA,
    )


def _hidden_heights(
    centres: tuple[Centres, Centres], times_s: Floats, gravity: float
) -> tuple[str, ...]:
    """Return a note where a sphere's height is not seen before the contact, else nothing.

    A small sphere may fly before the large one, or behind it, in all of the mirror's frames. Where
    heights that are seen change with time the pair does not fly at one height, and nothing is said.
    """
    try:
        split = split_at_contact(*centres, times_s, gravity)
    except ShotRefusedError:
        return ()
    if any(_drifting(own, times_s, own.frames >= split) for own in centres):
        return ()
    for name, own in zip("ab", centres, strict=True):
        before = own.frames < split
        shown = int(np.isfinite(own.sigma[before, 2]).sum())
        if shown < LEAST_HEIGHTS <= int(before.sum()):
            told = f"sphere {name} in {shown} of the {int(before.sum())} frames before the contact"
            return (f"no heights, as before one view: the top view shows {told}",)
    return ()


def _drifting(own: Centres, times_s: Floats, after: NDArray[np.bool_]) -> bool:
    """Whether the heights of a flight change as one view alone could not know."""
    for side in (~after, after):
        seen = side & np.isfinite(own.sigma[:, 2])
        if np.count_nonzero(seen) < LEAST_HEIGHTS:
            continue
        tau, places = times_s[own.frames[seen]], own.position[seen]
        speeds = np.polyfit(tau - tau.mean(), places, 1)[0]
        if abs(speeds[2]) > MOST_DRIFT * np.hypot(speeds[0], speeds[1]):
            return True
    return False


def _is_marked(seen: FilmMarkers) -> bool:
    """Whether half of a sphere's frames show a dark place."""
    return bool(np.count_nonzero(np.diff(seen.ends, prepend=0)) > len(seen.frames) / 2)


def _unlike_px(bias: FilterBias) -> float:
    """Return the slow error of one sphere's place against the other's, over the root of two, px.

    The same light shifts both alike, which moves no line of centres: only what they are shifted by
    unlike each other counts, and how well that is measured.
    """
    unlike = 0.5 * (LEFT_BY_THE_LENS * (bias.place[0] - bias.place[1])) ** 2
    return float(np.sqrt(np.mean(bias.place_sigma**2) + np.mean(unlike)))


def _outlined(
    frames: Singles, times_s: Floats, setup: Setup, settings: EdgeSettings
) -> tuple[float, FilmDiscs, FilmCurves, dict[View, tuple[float, float]]]:
    """Return the noise of a pixel, both discs in all frames with their curves, and their radii.

    Raises
    ------
    ShotRefusedError
        No two discs stand out, or frames repeat each other.
    """
    noise = noise_sd(frames)
    discs, curves = _followed(film_edges(frames, settings), times_s, noise, setup)
    refuse_repeats(frames, discs)
    diameters = (setup.spheres[0].diameter_m, setup.spheres[1].diameter_m)
    return noise, discs, curves, shared_radii(discs, diameters)


def _followed(
    edges: FilmEdges, times_s: Floats, noise: float, setup: Setup
) -> tuple[FilmDiscs, FilmCurves]:
    """Follow the discs by their edges; before a scene with edges of its own, by what moves.

    Raises
    ------
    ShotRefusedError
        They stand out neither by their edges, for this reason, nor by their motion.
    """
    try:
        return followed_discs(edges, times_s, setup, LEAST_COVERAGE)
    except ShotRefusedError as plainly:
        moving = silhouettes(edges.frames, noise)
        least = gradient_threshold(noise_sd(moving), edges.settings.sigma_px)
        try:
            silhouette = FilmEdges(moving, edges.settings, least)
            return followed_discs(silhouette, times_s, setup, LEAST_COVERAGE)
        except ShotRefusedError:
            raise plainly from None
