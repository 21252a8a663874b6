"""Learning how a pair of spheres looks from a film whose poses are roughly known.

Shading, markers and poses are improved in turn. The limit beyond which a residual counts no more
draws in slowly: a tight one would lock a misplaced marker out for ever.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.motion.rotation import rotation_matrix
from analysis.photometric.appearance import Knowledge, Sphere
from analysis.photometric.bundle import Lesson
from analysis.photometric.film import Film, fit_film, sights_of
from analysis.photometric.marker_search import missed_markers
from analysis.photometric.relief import add_residuals, changed_relief
from analysis.photometric.shading import HARMONICS, NUDGE, blurred_profiles
from analysis.photometric.shading_fit import COMMON, Samples, shading_equations
from analysis.photometric.shading_solve import solve_shading
from analysis.photometric.shared import Shared, add_frame, shared_size, solve_shared, tangents_of
from analysis.photometric.sight import Equations

Floats = NDArray[np.float64]

MOST_FRAMES = 10
"""Of a film: more tell little more of the spheres, and learning takes as much longer."""
LIMITS = (60.0, 30.0, 15.0, 8.0, 6.0, 6.0)
FINISH_LIMITS = np.array([40.0, 15.0, 6.0])
SEARCH_ROUNDS = (1, 2, 3)
SHARED_ROUNDS = (1, 3, 5)
RELIEF_FROM = 2
UNLIMITED = 1e3
TOGETHER_LIMITS = (15.0, 8.0, 6.0, 6.0)
NARROWEST_PX, WIDEST_PX = 0.35, 3.0
SCALE_FLOOR = 7e-4
"""Shading near the limb and the radius are one family: below this nothing tells them apart."""


def learn(film: Film, start: Knowledge, *, hold_scale: bool) -> Knowledge:
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
    for turn, limit in enumerate(LIMITS):
        shading_limit = limit if turn else UNLIMITED
        known = with_shading([few], known, shading_limit, hold_scale=hold_scale)
        if turn in SEARCH_ROUNDS:
            known = with_missed([few], known)
        if turn >= RELIEF_FROM:
            known = with_reliefs([few], known, limit)
        if turn in SHARED_ROUNDS:
            known = with_shared([few], known, limit)
        fit_film(few, known, np.full(2, limit))
    film.rescale(start.camera.optics, known.camera.optics.scales)
    fit_film(film, known, FINISH_LIMITS)
    film.refresh(known)
    return known


def learn_together(films: Sequence[Film], start: Knowledge, *, hold_scale: bool) -> Knowledge:
    """Learn the spheres from several films that already have poses.

    One film shows some markers only at the limb, and its radius is the less certain for it.
    """
    few = [film.picked(MOST_FRAMES) for film in films]
    known = with_missed(few, start)
    for limit in TOGETHER_LIMITS:
        known = with_shading(few, known, limit, hold_scale=hold_scale)
        known = with_reliefs(few, known, limit)
        known = with_shared(few, known, limit)
        for film in few:
            fit_film(film, known, np.full(1, limit))
    return known


def with_shading(
    films: Sequence[Film], known: Knowledge, limit: float, *, hold_scale: bool
) -> Knowledge:
    """Return the knowledge with the shading, radius and blur that fit all frames best."""
    camera, wider = known.camera, known.looks(NUDGE)
    size, views = len(HARMONICS) + COMMON, len(camera.views)
    normal, right = np.zeros((2, views, size, size)), np.zeros((2, views, size))
    for i, sphere in enumerate(known.spheres):
        samples = [
            Samples(blurred_profiles(sigma / radius).values, (disc, surface), limit)
            for sigma, radius, disc, surface in zip(
                known.sigma_px,
                camera.optics.scales * sphere.radius_m,
                wider[i].discs,
                wider[i].surfaces,
                strict=True,
            )
        ]
        for sight, stance in sights_of(films, known, i):
            for view in range(views):
                own = Equations(normal[i, view], right[i, view])
                shading_equations(sight, stance, view, samples[view], own)
    present = np.stack([sphere.shading for sphere in known.spheres])
    surface = solve_shading(normal, right, present, hold_radius=hold_scale)
    a, b = (replace(s, shading=c) for s, c in zip(known.spheres, surface.shading, strict=True))
    scales = camera.optics.scales * np.exp(surface.log_radius)
    for film in films:
        film.rescale(camera.optics, scales)
    return replace(
        known,
        spheres=(a, b),
        camera=camera.with_scales(scales),
        sigma_px=np.clip(known.sigma_px + surface.blur_px, NARROWEST_PX, WIDEST_PX),
        scale_sigma=0.0 if hold_scale else float(np.hypot(SCALE_FLOOR, surface.log_radius_sigma)),
    )


def with_reliefs(films: Sequence[Film], known: Knowledge, limit: float) -> Knowledge:
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


def with_missed(films: Sequence[Film], known: Knowledge) -> Knowledge:
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


def with_shared(films: Sequence[Film], known: Knowledge, limit: float) -> Knowledge:
    """Return the knowledge with better markers and scales of the views against each other."""
    camera, wider = known.camera, known.looks(NUDGE)
    views = len(camera.views)
    steps: list[Shared] = []
    for i, sphere in enumerate(known.spheres):
        size = shared_size(len(sphere.markers), views)
        equations = Equations(np.zeros((size, size)), np.zeros(size))
        lesson = Lesson((wider[i].discs, wider[i].surfaces), tangents_of(sphere.markers), limit)
        for sight, stance in sights_of(films, known, i):
            add_frame(sight, stance, lesson, equations)
        steps.append(solve_shared(equations, len(sphere.markers), views))
    a, b = (_changed(sphere, step) for sphere, step in zip(known.spheres, steps, strict=True))
    scales = camera.optics.scales * np.exp(_ratios(steps))
    for film in films:
        film.rescale(camera.optics, scales)
    return replace(known, spheres=(a, b), camera=camera.with_scales(scales))


def _changed(sphere: Sphere, step: Shared) -> Sphere:
    turns = np.einsum("mt,mtk->mk", step.markers, tangents_of(sphere.markers))
    return replace(
        sphere,
        markers=np.einsum("mij,mj->mi", rotation_matrix(turns), sphere.markers),
        alpha=float(np.clip(sphere.alpha + step.alpha, 0.03, 0.6)),
        darkness=float(np.clip(sphere.darkness + step.darkness, 0.05, 1.0)),
    )


def _ratios(steps: list[Shared]) -> Floats:
    """Average the views' scales against the front view's over both spheres, by their errors."""
    logs = np.array([step.log_scale for step in steps])
    weights = np.array([step.log_scale_sigma for step in steps]) ** -2.0
    return np.asarray((weights * logs).sum(axis=0) / weights.sum(axis=0))
