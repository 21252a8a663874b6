"""From frames to the poses of both spheres: outlines, markers, orientation, centres."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, Self

import numpy as np

from analysis.arrays import Floats, Grey, as_singles
from analysis.errors import ShotRefusedError
from analysis.imaging.assignment import LEAST_COVERAGE, follow
from analysis.imaging.discs import common_radius
from analysis.imaging.edge.facet import EdgePoints
from analysis.imaging.edge.frame import (
    EdgeSettings,
    FilmEdges,
    gradient_threshold,
    noise_sd,
)
from analysis.imaging.film_discs import FilmDiscs
from analysis.imaging.film_following import FilmCurves
from analysis.imaging.flight_hypotheses import Falling
from analysis.imaging.radii import Appearance, FilterBias, filter_bias, refine_outlines, view_radii
from analysis.imaging.stated_view import lowered, lowered_markers
from analysis.imaging.tracks import Spheres
from analysis.imaging.views import View, view_geometries
from analysis.motion.pattern import Orientations, orient
from analysis.motion.poses import LEAST_SIGMA_PX, Centres, centres
from analysis.motion.proximal import orient_by_steps
from analysis.motion.sightings import (
    Radii,
    SeenMarkers,
    lifted_again,
    marker_angle,
    markers_by_edges,
)
from analysis.setup import Rows, Setup

Matching = Literal["pattern", "proximal"]

SMALLEST_RADIUS_PX = 6.0
FRAMES_FOR_RADIUS = 3
SOME_ROWS = 16


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
    shared_px
        Slow error of an outline's place that all shots of a campaign share, where it is more than
        that of the filter's width.
    radii
        Radius of a and b in each view, pixels, as filtered.
    scales_px_per_m
        Scale of each view, the filter's bias taken out or as the set-up gives it.
    scale_sigma
        Relative standard error of the scale.
    centres, orientations
        Poses of a and b.
    notes
        Frames that show a sphere and hold no pose of it, with the reason, and other notes.
    left_out
        Those frames of a and b, with the reason.
    learned_alone
        The spheres did not look as they were known, and were learned from this shot by itself: its
        body axes and its scale are its own.
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
    notes: tuple[str, ...] = ()
    left_out: tuple[Mapping[int, str], Mapping[int, str]] = field(default_factory=lambda: ({}, {}))
    learned_alone: bool = False
    shared_px: float = 0.0

    def lowered(self, rows: int) -> Self:
        """Return the tracking with all pixels so many rows lower: those of a larger picture."""
        if rows == 0:
            return self
        a, b = (lowered(sphere, rows) for sphere in self.spheres)
        markers = tuple(lowered_markers(own, rows) for own in self.markers)
        return replace(self, spheres=(a, b), markers=(markers[0], markers[1]))


MOST_SCALE_CONFLICT = 0.02
"""A stated scale and the radius in the images differ by more than any shading: one is wrong."""
FRAMES_FOR_COLUMNS, LASTING_PX = 4, 0.05
"""With a sphere in both views, for the ratio of their scales; and what light moves a disc by, in
one view more than in the other, while it flies on."""
SCALE_SIGMA_FROM_IMAGES = 0.003
"""A radius from shaded edges is good to about this share of itself; none is without it."""


def track_spheres(
    frames: Grey,
    times_s: Floats,
    setup: Setup,
    settings: EdgeSettings,
    matching: Matching,
) -> Tracking:
    """Measure the poses of both spheres by edges, in every frame that shows them.

    The outlines are found twice: first plainly, then with the known radius and without those
    stretches of the limb that a marker of the learned pattern cuts.

    Raises
    ------
    ShotRefusedError
        With the step, the frame and the reason.
    """
    frames = as_singles(frames)
    edges = film_edges(frames, settings)
    discs, curves = followed_discs(edges, times_s, setup, LEAST_COVERAGE)
    refuse_repeats(frames, discs)
    radii = view_radii(discs)
    rough = Sighting.of(markers_by_edges(curves, discs, radii), radii, times_s)
    refined = refined_discs(discs, curves, rough, setup, settings)
    # Outlines of markers keep their image positions; their directions depend on the disc.
    again = tuple(lifted_again(own, refined, i, radii) for i, own in enumerate(rough.markers))
    seen = Sighting.of((again[0], again[1]), radii, times_s)
    if matching == "proximal":
        front = radii[View.FRONT]
        a, b = (
            orient_by_steps(own, radius, name)
            for own, radius, name in zip(seen.markers, front, "ab", strict=True)
        )
        seen = replace(seen, orientations=(a, b))
    bias = filter_bias(frames, discs, settings, noise_sd(frames))
    return tracking_of(refined, seen, setup, settings, bias)


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """The markers of both spheres, and how these stand by them.

    Attributes
    ----------
    markers, orientations
        Of a and b.
    radii
        Of a and b in each view, pixels.
    """

    markers: SeenMarkers
    orientations: tuple[Orientations, Orientations]
    radii: Radii

    @classmethod
    def of(cls, markers: SeenMarkers, radii: Radii, times_s: Floats) -> Self:
        """Return the orientations of markers; raise `ShotRefusedError` where they give none."""
        a, b = (orient(own, times_s, name) for own, name in zip(markers, "ab", strict=True))
        return cls(markers, (a, b), radii)

    @property
    def angle(self) -> float:
        """Angular radius of the markers, radians; 0 where none is seen."""
        return marker_angle(self.markers, self.radii)


def film_edges(frames: Grey, settings: EdgeSettings) -> FilmEdges:
    """Return the edges of a film above its noise; each frame's are found at their first use."""
    least = settings.least_strength or gradient_threshold(noise_sd(frames), settings.sigma_px)
    return FilmEdges(frames, settings, least)


def followed_discs(
    edges: FilmEdges, times_s: Floats, setup: Setup, least_coverage: float
) -> tuple[FilmDiscs, FilmCurves]:
    """Follow discs of the radii that edges or set-up give (`assignment.follow`)."""
    views, radii = view_geometries(setup.camera), _start_radii(edges, setup)
    scale = 2.0 * radii[0] / setup.spheres[0].diameter_m
    falling = Falling(times_s, scale * setup.environment.gravity_m_per_s2)
    return follow(edges, views, radii, falling, least_coverage=least_coverage)


def refined_discs(
    discs: FilmDiscs, curves: FilmCurves, seen: Sighting, setup: Setup, settings: EdgeSettings
) -> FilmDiscs:
    """Return the outlines without the stretches of the limb that markers cut."""
    a, b = (_standing(own, discs.found.shape[-1]) for own in seen.orientations)
    known = Appearance(seen.radii, (a, b), seen.angle)
    return refine_outlines(curves, view_geometries(setup.camera), discs, known, settings.sigma_px)


def tracking_of(
    discs: FilmDiscs,
    seen: Sighting,
    setup: Setup,
    settings: EdgeSettings,
    bias: FilterBias,
    *,
    least_px: float = LEAST_SIGMA_PX,
) -> Tracking:
    """Return the poses; raise `ShotRefusedError` where the images contradict the stated scale.

    Parameters
    ----------
    bias
        What the width of the filter does to the outlines.
    least_px
        Standard error of an outline's place at least, pixels.
    """
    views = view_geometries(setup.camera)
    scales, scale_sigma = _scales(seen.radii, bias.radius, setup)
    scales = _scales_by_columns(discs, scales)
    a, b = (centres(discs, i, views, scales, (settings.sigma_px, least_px)) for i in (0, 1))
    return Tracking(
        spheres=discs.tracks(),
        markers=seen.markers,
        marker_angle=seen.angle,
        filter_sigma_px=settings.sigma_px,
        radii=seen.radii,
        scales_px_per_m=scales,
        scale_sigma=scale_sigma,
        centres=(a, b),
        orientations=seen.orientations,
    )


def refuse_repeats(frames: Grey, discs: FilmDiscs) -> None:
    """Refuse frames that repeat the one before while a sphere flies: their times cannot be true.

    Raises
    ------
    ShotRefusedError
        With the first frame that does.
    """
    shown = np.asarray(discs.found.any(axis=(0, 1)))
    # Noise makes nearly all frames differ within a few rows.
    few = frames[:, ::SOME_ROWS]
    alike = (np.count_nonzero(few[1:] != few[:-1], axis=(1, 2)) == 0) & shown[1:] & shown[:-1]
    for k in np.flatnonzero(alike) + 1:
        if np.array_equal(frames[k], frames[k - 1]):
            raise ShotRefusedError("frames", "the same as the frame before, bit for bit", int(k))


def _start_radii(film: FilmEdges, setup: Setup) -> tuple[float, float]:
    """Return the radii of the discs of a and b to about a pixel."""
    a, b = (sphere.diameter_m for sphere in setup.spheres)
    if setup.camera.scale_px_per_m is not None:
        return setup.camera.scale_px_per_m * a / 2, setup.camera.scale_px_per_m * b / 2
    views, rows = 1, [setup.camera.front_view_rows]
    if setup.camera.top_view_rows is not None:
        views, rows = 2, [*rows, setup.camera.top_view_rows]
    # Beside the views there may be discs that are not counted, as in a mirror that is left out.
    points = [_within(film.whole(k).points, rows) for k in range(len(film))]
    busiest = sorted(points, key=lambda own: -len(own))[:FRAMES_FOR_RADIUS]
    if len(busiest[0]) < 12:
        raise ShotRefusedError("outlines", "no edges stand out of the noise in any frame")
    shape = film.whole(0).shape
    limits = SMALLEST_RADIUS_PX, min(shape) / 2
    sizes = {1.0: 2 * views} if a == b else {1.0: views, b / a: views}
    radius = float(np.median([common_radius(own, shape, limits, sizes) for own in busiest]))
    return radius, radius * b / a


def _within(points: EdgePoints, rows: Sequence[Rows]) -> EdgePoints:
    """Return the points that lie in any of these ranges of rows."""
    row = points.row
    return points.where(np.any([(first <= row) & (row < end) for first, end in rows], axis=0))


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


def _scales_by_columns(discs: FilmDiscs, scales: dict[View, float]) -> dict[View, float]:
    """Return the scales, that of the top view by its columns too, which show Y as the front's do.

    What a sphere moves by in the columns of both views gives the ratio of the scales; over many
    radii better than the radii do, of which light from one side takes a share in each view.
    """
    if View.TOP not in scales:
        return scales
    front, top = discs.views.index(View.FRONT), discs.views.index(View.TOP)
    ratio, weight = scales[View.TOP] / scales[View.FRONT], SCALE_SIGMA_FROM_IMAGES**-2.0
    total = weight * ratio
    for circles, found in zip(discs.circles, discs.found, strict=True):
        seen = found[front] & found[top]
        if np.count_nonzero(seen) < FRAMES_FOR_COLUMNS:
            continue
        moved, above = (
            circles[view, seen, 1] - circles[view, seen, 1].mean() for view in (front, top)
        )
        spread = float(moved @ moved)
        slope = float(moved @ above) / max(spread, 1e-9)
        off_px = max(float(np.sqrt(np.mean((above - slope * moved) ** 2))), LASTING_PX)
        own = spread / len(moved) / off_px**2
        total, weight = total + own * slope, weight + own
    return {**scales, View.TOP: scales[View.FRONT] * total / weight}
