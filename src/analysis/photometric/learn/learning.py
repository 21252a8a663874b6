"""Learning how a pair of spheres looks from a film whose poses are roughly known.

Shading, markers and poses are improved in turn. The limit beyond which a residual counts no more
draws in slowly: a tight one would lock a misplaced marker out for ever.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.motion.rotation import rotation_matrix
from analysis.photometric.follow.confirmation import borne_out
from analysis.photometric.follow.film import Film, fit_film, sights_of, take_out_shadows
from analysis.photometric.learn.appearance import NARROWEST_PX, Appearance, Sphere, profiles_of
from analysis.photometric.learn.marker_search import missed_markers
from analysis.photometric.learn.relief import add_residuals, changed_relief
from analysis.photometric.learn.shading_fit import COMMON, shading_equations, solve_shading
from analysis.photometric.learn.shared import (
    BENDS,
    Shared,
    add_frame,
    shared_size,
    solve_shared,
    tangents_of,
)
from analysis.photometric.learn.training_view import TrainingView
from analysis.photometric.learn.unsmeared import unsmeared
from analysis.photometric.render.shading import HARMONICS, NUDGE
from analysis.photometric.render.sight import Equations

MOST_FRAMES = 10
"""Frames of a film: more add little information on the spheres and take as much longer."""
LIMITS = (60.0, 30.0, 15.0, 8.0, 6.0, 6.0)
ORDINARY_DARKNESS = 0.6
"""Of the markers that LIMITS are for."""
FAINT_TURNS = 6
MARKED_FROM = 2
"""Iterations after which the markers determine the radius."""
LARGEST_SIGMA = 1e-3
"""Of the radius by the markers' noise, beyond which they do not determine it."""
FINISH_LIMITS = np.array([40.0, 15.0, 6.0])
SEARCH_ROUNDS = (1, 2, 3)
SHARED_FROM = 1
RELIEF_FROM = 2
INSIDE = 0.2
"""Weight of the inside of a disc in the shading, where a relief takes the residuals there."""
UNLIMITED = 1e3
TOGETHER_LIMITS = (15.0, 8.0, 6.0, 6.0)
SEARCH_TOGETHER = (0, 1)
EXTENDING_LIMITS = (15.0, 6.0, 6.0)
WIDEST_PX = 3.0
LIMB_SCALE_SIGMA, MARKER_SCALE_SIGMA = 5e-3, 5e-5
"""Relative accuracy of the scale, by the limb and by the markers, for spheres of known diameter.

Light from one side passes for another radius at the limb. Markers move across the disc and are seen
in both views at once, which gives the radius without the limb.
"""
RELIEF_SCALE_SIGMA, COARSE_SCALE_SIGMA = 1.2e-3, 2e-4
"""Beside it, for each unit of `Appearance.relief_share`, and of `coarseness` beyond 1
(docs/decisions/0060-the-scale-by-markers.md)."""
NEARNESS_SCALE_SIGMA = 3.5e-4
"""Beside it, where a camera is so near that perspective shows: its axis is taken for the middle of
the frame.
"""
FARTHEST_PER_M = 0.05
"""Nearness below which a camera is taken as orthographic: farther than 20 m. Shading alone looks
like a nearness of up to 0.01, and each 0.01 tilts Z against X by 6e-4."""
OVERSTEP = 1.5
"""Factor on steps of the radius by the markers: shading learned with another radius slows them."""


def learn(film: Film, start: Appearance, *, hold_scale: bool) -> Appearance:
    """Learn the spheres from a film, and improve its poses in place.

    Parameters
    ----------
    film
        With poses within about 2 pixels and 3 degrees.
    start
        Camera, markers and a first guess of the rest.
    hold_scale
        Keep the front view's scale.
    """
    film.refresh(start)
    few, known = film.picked(MOST_FRAMES), start
    for turn, limit in enumerate(_limits(start.spheres[0].darkness)):
        shading_limit = limit if turn else UNLIMITED
        marked = turn >= MARKED_FROM and radius_determined(known)
        inside = INSIDE if turn >= RELIEF_FROM else 1.0
        hold = hold_scale or marked
        known = with_shading([few], known, shading_limit, hold_radius=hold, inside=inside)
        if turn in SEARCH_ROUNDS:
            known = with_missed([few], known)
        elif turn > SEARCH_ROUNDS[-1]:
            known = without_false([few], known)
        if turn >= RELIEF_FROM:
            known = with_reliefs([few], known, limit)
        if turn >= SHARED_FROM:
            known = with_shared([few], known, limit, move_radius=marked, hold_scale=hold_scale)
        fit_film(few, known, np.full(2, limit))
    film.keep_places(start.camera.optics, known.camera.optics)
    fit_film(film, known, FINISH_LIMITS)
    film.refresh(known)
    return known


def _limits(darkness: float) -> tuple[float, ...]:
    """Return the limit of each turn.

    What faint markers lack of the light must be beyond it as that of others is, or the shading
    takes them for its own; and they part from it slowly.
    """
    if darkness >= ORDINARY_DARKNESS:
        return LIMITS
    nearer = (max(darkness / ORDINARY_DARKNESS * own, LIMITS[-1]) for own in LIMITS)
    return *nearer, *LIMITS[-1:] * FAINT_TURNS


def learn_together(films: Sequence[Film], start: Appearance, *, hold_scale: bool) -> Appearance:
    """Learn the spheres from several films that already have poses.

    One film shows some markers only at the limb, and its radius is the less certain for it.
    """
    few = [unsmeared(film.picked(MOST_FRAMES), start) for film in films]
    known = start
    for turn, limit in enumerate(TOGETHER_LIMITS):
        if turn in SEARCH_TOGETHER:
            known = with_missed(few, known)
        known = without_false(few, known)
        marked = radius_determined(known)
        hold = hold_scale or marked
        known = with_shading(few, known, limit, hold_radius=hold, inside=INSIDE)
        known = with_reliefs(few, known, limit)
        known = with_shared(few, known, limit, move_radius=marked, hold_scale=hold_scale)
        for film in few:
            fit_film(film, known, np.full(1, limit))
            take_out_shadows(film, known)
    return known


def extended(film: Film, known: Appearance) -> Appearance:
    """Return the knowledge with markers added that a film of the known pair shows.

    One film alone does not turn every side of a sphere to the camera. What several films have
    taught stays as it is: this film alone would move it to where its own errors are, and all later
    shots with it. The same object comes back where nothing is added.
    """
    few = unsmeared(film.picked(MOST_FRAMES), known)
    more, before = with_missed([few], known), [len(s.markers) for s in known.spheres]
    if [len(s.markers) for s in more.spheres] == before:
        return known
    # So far the new markers count as shadows.
    take_out_shadows(few, more)
    for limit in EXTENDING_LIMITS:
        fit_film(few, more, np.full(1, limit))
        if known.films > 1:
            more = _with_added(few, more, limit, before)
        else:
            more = with_shared([few], more, limit, move_radius=False, hold_scale=True)
    return more


def _with_added(film: Film, known: Appearance, limit: float, before: Sequence[int]) -> Appearance:
    """Return the knowledge with better places of the markers beyond so many of each sphere."""
    a, b = (
        sphere
        if len(sphere.markers) == own
        else _changed(sphere, _step([film], known, i, limit, settled=own))
        for i, (sphere, own) in enumerate(zip(known.spheres, before, strict=True))
    )
    return replace(known, spheres=(a, b))


def with_shading(
    films: Sequence[Film], known: Appearance, limit: float, *, hold_radius: bool, inside: float
) -> Appearance:
    """Return the knowledge with the shading, radius and blur that fit all frames best.

    Parameters
    ----------
    inside
        Of `TrainingView`.
    """
    camera = known.camera
    size, views = len(HARMONICS) + COMMON, len(camera.views)
    normal, right = np.zeros((2, views, size, size)), np.zeros((2, views, size))
    for i in range(len(known.spheres)):
        training = _training_view(known, i, limit)._replace(inside=inside)
        for sight, stance in sights_of(films, known, i):
            for view in range(views):
                own = Equations(normal[i, view], right[i, view])
                shading_equations(sight, stance, view, training, own)
    present = np.stack([sphere.shading for sphere in known.spheres])
    surface = solve_shading(normal, right, present, hold_radius=hold_radius)
    a, b = (replace(s, shading=c) for s, c in zip(known.spheres, surface.shading, strict=True))
    limb_sigma = float(np.hypot(LIMB_SCALE_SIGMA, surface.log_radius_sigma))
    scales = camera.optics.scales * np.exp(surface.log_radius)
    changed = camera.with_scales(scales)
    for film in films:
        film.keep_places(camera.optics, changed.optics)
    return replace(
        known,
        spheres=(a, b),
        camera=changed,
        sigma_px=np.clip(known.sigma_px + surface.blur_px, NARROWEST_PX, WIDEST_PX),
        scale_sigma=known.scale_sigma if hold_radius else limb_sigma,
    )


def with_reliefs(films: Sequence[Film], known: Appearance, limit: float) -> Appearance:
    """Return the knowledge with what smooth shading leaves inside the discs."""
    spheres = []
    for i, sphere in enumerate(known.spheres):
        sums, weights = np.zeros_like(sphere.reliefs), np.zeros_like(sphere.reliefs)
        for sight, stance in sights_of(films, known, i):
            for view in range(len(sums)):
                add_residuals(sight, stance, view, limit, (sums[view], weights[view]))
        levels = np.maximum(np.abs(sphere.shading[:, 0]), 1.0)
        reliefs = [
            changed_relief(old, (total, weight), float(level))
            for old, total, weight, level in zip(sphere.reliefs, sums, weights, levels, strict=True)
        ]
        spheres.append(replace(sphere, reliefs=np.stack(reliefs)))
    return replace(known, spheres=(spheres[0], spheres[1]))


def with_missed(films: Sequence[Film], known: Appearance) -> Appearance:
    """Return the knowledge with markers added that the frames show."""
    a, b = (
        replace(
            sphere,
            markers=np.concatenate(
                [sphere.markers, missed_markers(sights_of(films, known, i), known, i)]
            ),
        )
        for i, sphere in enumerate(known.spheres)
    )
    return replace(known, spheres=(a, b))


def without_false(films: Sequence[Film], known: Appearance, *, unseen: bool = True) -> Appearance:
    """Return the appearance without the markers that the frames do not confirm.

    Parameters
    ----------
    unseen
        Keep those that never face a view. A feature at the limb throughout a film may be no marker;
        other films that turn its place to the camera would seem to show other spheres.
    """
    a, b = (
        replace(s, markers=s.markers[borne_out(sights, len(s.markers), unseen=unseen)])
        for s, sights in ((s, sights_of(films, known, i)) for i, s in enumerate(known.spheres))
    )
    return replace(known, spheres=(a, b))


def radius_determined(known: Appearance) -> bool:
    """Whether the markers determine the radius."""
    return known.camera_sigma[0] < LARGEST_SIGMA


def with_shared(
    films: Sequence[Film], known: Appearance, limit: float, *, move_radius: bool, hold_scale: bool
) -> Appearance:
    """Return the appearance with better markers, and camera parameters by markers and tracks.

    Scales of the views against each other, the camera's nearness and, if they may move, the radii
    of the discs: by a scale that is held each is drawn with the radius that it has, by one that is
    not the spheres are as large as stated, in the mean of both.
    """
    camera = known.camera
    steps = [_step(films, known, i, limit) for i in range(len(known.spheres))]
    change, sigma = _agreed(steps)
    grown = OVERSTEP * np.array([step.camera[0] for step in steps]) * move_radius
    nearer = 0.0 if hold_scale else float(grown.mean())
    a, b = (
        replace(_changed(sphere, step), radius_m=sphere.radius_m * float(np.exp(own)))
        for sphere, step, own in zip(known.spheres, steps, grown - nearer, strict=True)
    )
    scales = camera.optics.scales * np.exp(nearer + np.append(0.0, change[1:-BENDS]))
    nearness = camera.optics.nearness + float(change[-BENDS])
    far = nearness < FARTHEST_PER_M
    changed = camera.with_scales(scales).with_nearness(0.0 if far else nearness)
    changed = changed.with_shifted_mirror(float(change[-1]))
    for film in films:
        film.keep_places(camera.optics, changed.optics)
    # Light at the limb, as of a lamp beside or gloss, biases the markers' estimate too.
    limb = float(np.mean([step.limb for step in steps]))
    near = 0.0 if far else NEARNESS_SCALE_SIGMA
    coarse = (known.coarseness - 1.0) * COARSE_SCALE_SIGMA
    lit = known.relief_share * RELIEF_SCALE_SIGMA
    scale_sigma = float(np.linalg.norm([MARKER_SCALE_SIGMA + coarse, lit, near, sigma[0], limb]))
    radius_px = float(scales[0]) * (a.radius_m + b.radius_m) / 2
    apart_px = radius_px * float(np.sqrt(np.mean([step.limb**2 for step in steps])))
    return replace(
        known,
        spheres=(a, b),
        camera=changed,
        scale_sigma=scale_sigma if move_radius and not hold_scale else known.scale_sigma,
        camera_sigma=tuple(map(float, sigma)),
        limb_px=apart_px if move_radius else known.limb_px,
        pattern_sigma_rad=max(step.marker_sigma for step in steps),
    )


def _step(
    films: Sequence[Film], known: Appearance, sphere: int, limit: float, *, settled: int = 0
) -> Shared:
    """Return what all frames of a sphere correct; so many of its first markers stay."""
    views = len(known.camera.views)
    size = shared_size(len(known.spheres[sphere].markers), views)
    equations = Equations(np.zeros((size, size)), np.zeros(size))
    training = _training_view(known, sphere, limit)
    for sight, stance in sights_of(films, known, sphere):
        add_frame(sight, stance, training, equations)
    return solve_shared(equations, training.tangents, views, settled=settled)


def _training_view(known: Appearance, sphere: int, limit: float) -> TrainingView:
    wider = known.looks(NUDGE)[sphere]
    tangents = tangents_of(known.spheres[sphere].markers)
    return TrainingView((wider.discs, wider.surfaces), profiles_of(known, sphere), tangents, limit)


def _changed(sphere: Sphere, step: Shared) -> Sphere:
    turns = np.einsum("mt,mtk->mk", step.markers, tangents_of(sphere.markers))
    return replace(
        sphere,
        markers=np.einsum("mij,mj->mi", rotation_matrix(turns), sphere.markers),
        alpha=float(np.clip(sphere.alpha + step.alpha, 0.03, 0.6)),
        darkness=float(np.clip(sphere.darkness + step.darkness, 0.05, 1.0)),
    )


def _agreed(steps: list[Shared]) -> tuple[Floats, Floats]:
    """Return the weighted mean of both spheres' camera parameters, with its errors."""
    weight = sum(step.camera_weight for step in steps)
    covariance = np.linalg.inv(weight)
    change = covariance @ sum(step.camera_weight @ step.camera for step in steps)
    return np.asarray(change), np.sqrt(np.diag(covariance))
