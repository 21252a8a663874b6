"""From frames to the poses of both spheres: outlines, markers, orientation, centres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.errors import ShotRefusedError
from analysis.imaging.assignment import LEAST_COVERAGE, follow
from analysis.imaging.dark_places import FAINT_DARKNESS, LEAST_DARKNESS
from analysis.imaging.discs import common_radius
from analysis.imaging.film_discs import FilmDiscs
from analysis.imaging.film_following import FilmCurves
from analysis.imaging.frame import (
    EdgeSettings,
    FilmEdges,
    gradient_threshold,
    noise_sd,
)
from analysis.imaging.radii import filter_bias, shared_radii, view_radii
from analysis.imaging.refinement import Knowledge, refine_outlines
from analysis.imaging.silhouettes import silhouettes
from analysis.imaging.tracks import Spheres
from analysis.imaging.views import View, view_geometries
from analysis.motion.chained import orient_by_steps
from analysis.motion.pattern import Orientations, orient
from analysis.motion.poses import Centres, centres
from analysis.motion.sightings import (
    Radii,
    SeenMarkers,
    lifted_again,
    marker_angle,
    markers_by_darkness,
    markers_by_edges,
)
from analysis.setup import Setup

Floats = NDArray[np.float64]

Matching = Literal["pattern", "proximal"]

SMALLEST_RADIUS_PX = 6.0
FRAMES_FOR_RADIUS = 3
SOME_ROWS = 16
LEAST_COVERAGE_OF_A_START = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Tracking:
    """Both spheres through all frames.

    Attributes
    ----------
    spheres
        Outlines of a and b by view.
    markers
        Markers of a and b by frame.
    marker_angle
        Angular radius of the markers, radians; 0 where none is seen.
    filter_sigma_px
        Width of the edge filter; of a method without one, the width that has its slow error.
    radii
        Radius of a and b in each view, pixels, as filtered.
    scales_px_per_m
        Scale of each view, the filter's bias taken out or as the set-up gives it.
    scale_sigma
        Relative standard error of the scale.
    centres, orientations
        Poses of a and b.
    """

    spheres: Spheres
    markers: SeenMarkers
    marker_angle: float
    filter_sigma_px: float
    radii: dict[View, tuple[float, float]]
    scales_px_per_m: dict[View, float]
    scale_sigma: float
    centres: tuple[Centres, Centres]
    orientations: tuple[Orientations, Orientations]


MOST_SCALE_CONFLICT = 0.02
"""A stated scale and the radius in the images differ by more than any shading: one is wrong."""
SCALE_SIGMA_FROM_IMAGES = 0.003
"""A radius from shaded edges is good to about this share of itself; none is without it."""


def track_spheres(
    frames: NDArray[np.uint8],
    times_s: Floats,
    setup: Setup,
    settings: EdgeSettings,
    matching: Matching,
    *,
    for_a_start: bool = False,
) -> Tracking:
    """Measure the poses of both spheres in every frame that shows them.

    The outlines are found twice: once plainly, and once the radius is known and the learned
    marker pattern says which stretches of the limb a marker cuts.

    Parameters
    ----------
    for_a_start
        Go on where a sphere shows less than most of its limb in every frame, and find the markers
        as dark places instead of by their edges: coarser, but also beside highlights and where a
        marker is a few pixels wide. Good enough to begin a rendering with.

    Raises
    ------
    ShotRefusedError
        With the step, the frame and the reason.
    """
    views = view_geometries(setup.camera)
    noise = noise_sd(frames)
    threshold = settings.least_strength or gradient_threshold(noise, settings.sigma_px)
    edges = FilmEdges(frames, settings, threshold)
    least = LEAST_COVERAGE_OF_A_START if for_a_start else LEAST_COVERAGE
    try:
        discs, curves = _followed(edges, setup, least)
    except ShotRefusedError as plainly:
        if not for_a_start:
            raise
        discs, curves = _followed_by_motion(edges, noise, setup, plainly)
    refuse_repeats(frames, discs)
    diameters = (setup.spheres[0].diameter_m, setup.spheres[1].diameter_m)
    radii = shared_radii(discs, diameters) if for_a_start else view_radii(discs)
    bias = filter_bias(frames, discs, settings, noise)

    def markers(discs: FilmDiscs, darkness: float) -> SeenMarkers:
        if for_a_start:
            return markers_by_darkness(frames, views, discs, radii, (darkness, noise))
        return markers_by_edges(curves, discs, radii)

    darkness = LEAST_DARKNESS
    seen = markers(discs, darkness)
    try:
        orientations = _orientations(seen, times_s)
    except ShotRefusedError as plainly:
        if not for_a_start:
            raise
        darkness = FAINT_DARKNESS
        seen = markers(discs, darkness)
        orientations = _orientations_or(plainly, seen, times_s)
    standing = _standing(orientations[0], len(frames)), _standing(orientations[1], len(frames))
    known = Knowledge(radii, standing, marker_angle(seen, radii))
    discs = refine_outlines(curves, views, discs, known, settings.sigma_px)
    # Dark places depend on where the limb is; closed edges do not.
    seen = markers(discs, darkness) if for_a_start else _again(seen, discs, radii)
    orientations = _orientations(seen, times_s)
    if matching == "proximal":
        front = radii[View.FRONT]
        orientations = (
            orient_by_steps(seen[0], front[0], "a"),
            orient_by_steps(seen[1], front[1], "b"),
        )
    scales, scale_sigma = _scales(radii, bias, setup)
    placed = [centres(discs, i, views, scales, settings.sigma_px) for i in (0, 1)]
    return Tracking(
        spheres=discs.tracks(),
        markers=seen,
        marker_angle=marker_angle(seen, radii),
        filter_sigma_px=settings.sigma_px,
        radii=radii,
        scales_px_per_m=scales,
        scale_sigma=scale_sigma,
        centres=(placed[0], placed[1]),
        orientations=orientations,
    )


def refuse_repeats(frames: NDArray[np.uint8], discs: FilmDiscs) -> None:
    """Refuse frames that repeat the one before while a sphere flies: their times cannot be true.

    Raises
    ------
    ShotRefusedError
        With the first frame that does.
    """
    shown = np.asarray(discs.found.any(axis=(0, 1)))
    # Noise tells nearly all apart by a few rows.
    few = frames[:, ::SOME_ROWS]
    alike = (np.count_nonzero(few[1:] != few[:-1], axis=(1, 2)) == 0) & shown[1:] & shown[:-1]
    for k in np.flatnonzero(alike) + 1:
        if np.array_equal(frames[k], frames[k - 1]):
            raise ShotRefusedError("frames", "the same as the frame before, bit for bit", int(k))


def _followed(edges: FilmEdges, setup: Setup, least: float) -> tuple[FilmDiscs, FilmCurves]:
    """Follow the discs of whatever radius the edges or the set-up tell."""
    views, radius = view_geometries(setup.camera), _start_radius(edges, setup)
    return follow(edges, views, radius, least_coverage=least)


def _followed_by_motion(
    edges: FilmEdges, noise: float, setup: Setup, plainly: ShotRefusedError
) -> tuple[FilmDiscs, FilmCurves]:
    """Follow the discs that move before a scene with edges of its own.

    Raises
    ------
    ShotRefusedError
        The one given: they do not stand out by their motion either.
    """
    moving = silhouettes(edges.frames, noise)
    least = gradient_threshold(noise_sd(moving), edges.settings.sigma_px)
    try:
        return _followed(FilmEdges(moving, edges.settings, least), setup, LEAST_COVERAGE_OF_A_START)
    except ShotRefusedError:
        raise plainly from None


def _start_radius(film: FilmEdges, setup: Setup) -> float:
    """Return the discs' radius to about a pixel."""
    if setup.camera.scale_px_per_m is not None:
        diameter = sum(s.diameter_m for s in setup.spheres) / 2
        return setup.camera.scale_px_per_m * diameter / 2
    edges = [film.whole(k) for k in range(len(film))]
    busiest = sorted(edges, key=lambda e: -len(e.points))[:FRAMES_FOR_RADIUS]
    if len(busiest[0].points) < 12:
        raise ShotRefusedError("outlines", "no edges stand out of the noise in any frame")
    discs = 2 if setup.camera.top_view_rows is None else 4
    largest = min(busiest[0].shape) / 2
    found = [common_radius(e.points, e.shape, SMALLEST_RADIUS_PX, largest, discs) for e in busiest]
    return float(np.median(found))


def _orientations(seen: SeenMarkers, times_s: Floats) -> tuple[Orientations, Orientations]:
    return orient(seen[0], times_s, "a"), orient(seen[1], times_s, "b")


def _orientations_or(
    plainly: ShotRefusedError, seen: SeenMarkers, times_s: Floats
) -> tuple[Orientations, Orientations]:
    """Return the orientations, or refuse the shot for the reason that it had before."""
    try:
        return _orientations(seen, times_s)
    except ShotRefusedError:
        raise plainly from None


def _again(seen: SeenMarkers, discs: FilmDiscs, radii: Radii) -> SeenMarkers:
    return lifted_again(seen[0], discs, 0, radii), lifted_again(seen[1], discs, 1, radii)


def _standing(orientations: Orientations, frames: int) -> Floats:
    """Return the directions of a sphere's markers in rig axes, shape (frames, markers, 3)."""
    standing = np.full((frames, *orientations.pattern.shape), np.nan)
    turned = np.swapaxes(orientations.rotation, 1, 2)
    standing[orientations.frames] = orientations.pattern @ turned
    return standing


def _scales(
    radii: dict[View, tuple[float, float]], bias: dict[View, float], setup: Setup
) -> tuple[dict[View, float], float]:
    """Return the scale of each view, px/m, and its relative error.

    A given scale holds for the front view; the top view keeps its ratio to it.

    Raises
    ------
    ShotRefusedError
        The images contradict the given scale.
    """
    diameters = [sphere.diameter_m for sphere in setup.spheres]
    measured = {
        view: float(
            np.mean([2 * (r - bias[view]) / d for r, d in zip(pair, diameters, strict=True)])
        )
        for view, pair in radii.items()
    }
    given = setup.camera.scale_px_per_m
    if given is None:
        return measured, SCALE_SIGMA_FROM_IMAGES
    off = measured[View.FRONT] / given - 1.0
    if abs(off) > MOST_SCALE_CONFLICT:
        raise ShotRefusedError(
            "outlines",
            f"the spheres' outlines give {measured[View.FRONT]:.1f} px/m with the stated "
            f"diameters, the set-up says {given:.1f}: {100 * off:+.1f} % apart, "
            f"{100 * MOST_SCALE_CONFLICT:g} % are allowed; check scale_px_per_m and diameter_m",
        )
    return {view: given * s / measured[View.FRONT] for view, s in measured.items()}, 0.0
