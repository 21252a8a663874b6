"""The first look at spheres that are not known: poses by edges, good enough to begin to render.

Coarser than tracking by edges alone (`analysis.tracking.track_spheres`) and more tolerant. It works
where a sphere shows a third of its limb, before a scene with edges of its own, beside
highlights, and where markers are faint or a few pixels wide.
"""

from __future__ import annotations

from dataclasses import replace

from analysis.arrays import Floats, Grey
from analysis.errors import ShotRefusedError
from analysis.imaging.edge.frame import EdgeSettings, FilmEdges, gradient_threshold, noise_sd
from analysis.imaging.film_discs import FilmDiscs
from analysis.imaging.film_following import FilmCurves
from analysis.imaging.marker.dark_places import FAINT_DARKNESS, LEAST_DARKNESS
from analysis.imaging.marker.markers import film_markers
from analysis.imaging.radii import filter_bias, shared_radii
from analysis.imaging.silhouettes import silhouettes
from analysis.imaging.views import view_geometries
from analysis.motion.pattern import Orientations
from analysis.motion.sightings import markers_by_darkness
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

LEAST_COVERAGE = 0.3
LIMB_SCALE_SIGMA = 0.005
"""Light from one side makes a radius 0.3 to 0.8 % too small where no markers contradict it."""


def first_tracking(frames: Grey, times_s: Floats, setup: Setup) -> Tracking:
    """Find both spheres in every frame that shows them, and their markers as dark places.

    Raises
    ------
    ShotRefusedError
        With the step, the frame and the reason.
    """
    settings, noise = EdgeSettings(), noise_sd(frames)
    discs, curves = _followed(film_edges(frames, settings), noise, setup)
    refuse_repeats(frames, discs)
    diameters = (setup.spheres[0].diameter_m, setup.spheres[1].diameter_m)
    radii, views = shared_radii(discs, diameters), view_geometries(setup.camera)

    def marked(discs: FilmDiscs, darkness: float) -> Sighting:
        seen = markers_by_darkness(frames, views, discs, radii, (darkness, noise))
        return Sighting.of(seen, radii, times_s)

    darkness = LEAST_DARKNESS
    try:
        rough = marked(discs, darkness)
    except ShotRefusedError as plainly:
        darkness = FAINT_DARKNESS
        try:
            rough = marked(discs, darkness)
        except ShotRefusedError:
            raise plainly from None
    refined = refined_discs(discs, curves, rough, setup, settings)
    # Dark places depend on where the limb is.
    seen = marked(refined, darkness)
    return tracking_of(refined, seen, setup, settings, filter_bias(frames, discs, settings, noise))


def track_unmarked(frames: Grey, setup: Setup, reason: str) -> Tracking:
    """Measure where both spheres are by their outlines alone: spheres without markers have no spin.

    Their radii are held in the ratio of the diameters, and centres are those of the edge filter.

    Parameters
    ----------
    reason
        Why no orientation is known, for the notes.

    Raises
    ------
    ShotRefusedError
        With the step, the frame and the reason.
    """
    settings, noise = EdgeSettings(), noise_sd(frames)
    discs, curves = _followed(film_edges(frames, settings), noise, setup)
    refuse_repeats(frames, discs)
    radii = shared_radii(discs, (setup.spheres[0].diameter_m, setup.spheres[1].diameter_m))
    unmarked = Orientations.none()
    seen = Sighting((film_markers({}), film_markers({})), (unmarked, unmarked), radii)
    refined = refined_discs(discs, curves, seen, setup, settings)
    bias = filter_bias(frames, discs, settings, noise)
    tracking = tracking_of(refined, seen, setup, settings, bias)
    return replace(
        tracking,
        notes=(f"measured by outlines alone, spins are open: {reason}",),
        scale_sigma=tracking.scale_sigma and LIMB_SCALE_SIGMA,
    )


def _followed(edges: FilmEdges, noise: float, setup: Setup) -> tuple[FilmDiscs, FilmCurves]:
    """Follow the discs by their edges; before a scene with edges of its own, by what moves.

    Raises
    ------
    ShotRefusedError
        They stand out neither by their edges, for this reason, nor by their motion.
    """
    try:
        return followed_discs(edges, setup, LEAST_COVERAGE)
    except ShotRefusedError as plainly:
        moving = silhouettes(edges.frames, noise)
        least = gradient_threshold(noise_sd(moving), edges.settings.sigma_px)
        try:
            return followed_discs(FilmEdges(moving, edges.settings, least), setup, LEAST_COVERAGE)
        except ShotRefusedError:
            raise plainly from None
