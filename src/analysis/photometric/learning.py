"""Learning how a pair of spheres looks from a film whose poses are roughly known.

Shading, markers with radius and blur, and poses are improved in turn. The limit beyond which a
residual counts no more draws in slowly: a tight one would lock a misplaced marker out for ever.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.motion.rotation import rotation_matrix
from analysis.photometric.appearance import Knowledge, Sphere
from analysis.photometric.bundle import (
    VIEW_SHARED,
    Shared,
    bundle_frame,
    solve_bundle,
    tangents_of,
)
from analysis.photometric.film import Film, fit_film, others_of
from analysis.photometric.marker_search import missed_markers
from analysis.photometric.relief import add_residuals, changed_relief
from analysis.photometric.shading import HARMONICS, NUDGE, blurred_profiles
from analysis.photometric.shading_fit import COMMON, shading_equations
from analysis.photometric.shading_solve import solve_shading

Floats = NDArray[np.float64]

LIMITS = (60.0, 30.0, 15.0, 8.0, 6.0, 6.0)
SEARCH_ROUNDS = (1, 2, 3)
BUNDLE_FROM = 1
RELIEF_FROM = 2
NARROWEST_PX, WIDEST_PX = 0.35, 3.0
SCALE_FLOOR = 4e-4
"""Shading near the limb and the radius are one family: below this nothing tells them apart."""


def learn(film: Film, start: Knowledge, hold_scale: bool) -> Knowledge:
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
    known = start
    film.refresh(known)
    for turn, limit in enumerate(LIMITS):
        known = with_shading(film, known, limit if turn else 1e3, hold_scale)
        if turn in SEARCH_ROUNDS:
            known = with_missed(film, known)
        if turn >= RELIEF_FROM:
            known = with_reliefs(film, known, limit)
        if turn >= BUNDLE_FROM:
            known = with_shared(film, known, limit)
        fit_film(film, known.camera, known.looks(), np.full(2, limit))
        if turn == 2:
            film.refresh(known)
    return known


def with_shading(film: Film, known: Knowledge, limit: float, hold_scale: bool) -> Knowledge:
    """Return the knowledge with the shading, radius and blur that fit all frames best."""
    camera, looks, wider = known.camera, known.looks(), known.looks(NUDGE)
    size, views = len(HARMONICS) + COMMON, len(camera.views)
    normal, right = np.zeros((2, views, size, size)), np.zeros((2, views, size))
    discs = film.discs(camera, (looks[0].radius_m, looks[1].radius_m))
    for i, look in enumerate(looks):
        for view in range(views):
            radius = camera.optics.scales[view] * look.radius_m
            profiles = blurred_profiles(known.sigma_px[view] / radius).values
            for k in np.flatnonzero(film.placed[i]):
                shading_equations(
                    film.scene(k),
                    camera.optics,
                    look,
                    (profiles, wider[i].tables[view]),
                    view,
                    film.centre[i, k],
                    film.rotation[i, k],
                    film.lights[i, k, view],
                    others_of(discs[k], i)[view],
                    limit,
                    normal[i, view],
                    right[i, view],
                )
    present = np.stack([sphere.shading for sphere in known.spheres])
    surface = solve_shading(normal, right, present, hold_scale)
    a, b = (replace(s, shading=c) for s, c in zip(known.spheres, surface.shading, strict=True))
    scales = camera.optics.scales * np.exp(surface.log_radius)
    film.rescale(camera.optics, scales)
    formal = float(np.hypot(SCALE_FLOOR, surface.log_radius_sigma))
    return replace(
        known,
        spheres=(a, b),
        camera=camera.with_scales(scales),
        sigma_px=np.clip(known.sigma_px + surface.blur_px, NARROWEST_PX, WIDEST_PX),
        scale_sigma=0.0 if hold_scale else formal,
    )


def with_reliefs(film: Film, known: Knowledge, limit: float) -> Knowledge:
    """Return the knowledge with what smooth shading leaves inside the discs."""
    camera, looks = known.camera, known.looks()
    discs = film.discs(camera, (looks[0].radius_m, looks[1].radius_m))
    spheres = []
    for i, (sphere, look) in enumerate(zip(known.spheres, looks, strict=True)):
        sums, weights = np.zeros_like(sphere.reliefs), np.zeros_like(sphere.reliefs)
        for k in np.flatnonzero(film.placed[i]):
            others = others_of(discs[k], i)
            for view in range(len(camera.views)):
                add_residuals(
                    film.scene(k),
                    camera.optics,
                    look,
                    view,
                    film.centre[i, k],
                    film.rotation[i, k],
                    film.lights[i, k, view],
                    others[view],
                    limit,
                    sums[view],
                    weights[view],
                )
        reliefs = [
            changed_relief(old, s, w, film.noise, max(abs(float(level)), 1.0))
            for old, s, w, level in zip(
                sphere.reliefs, sums, weights, sphere.shading[:, 0], strict=True
            )
        ]
        spheres.append(replace(sphere, reliefs=np.stack(reliefs)))
    return replace(known, spheres=(spheres[0], spheres[1]))


def with_missed(film: Film, known: Knowledge) -> Knowledge:
    """Return the knowledge with markers added that the frames show."""
    spheres = [
        replace(
            sphere,
            markers=np.concatenate([sphere.markers, missed_markers(film, known.camera, look, i)]),
        )
        for i, (sphere, look) in enumerate(zip(known.spheres, known.looks(), strict=True))
    ]
    return replace(known, spheres=(spheres[0], spheres[1]))


def with_shared(film: Film, known: Knowledge, limit: float) -> Knowledge:
    """Return the knowledge after one bundle step of both spheres."""
    camera = known.camera
    looks, wider = known.looks(), known.looks(NUDGE)
    discs = film.discs(camera, (looks[0].radius_m, looks[1].radius_m))
    views = len(camera.views)
    steps: list[Shared] = []
    for i, look in enumerate(looks):
        size = 2 * len(look.markers) + 2 + VIEW_SHARED * views
        whole, aim = np.zeros((size, size)), np.zeros(size)
        tangents = tangents_of(look.markers)
        for k in np.flatnonzero(film.placed[i]):
            bundle_frame(
                film.scene(k),
                camera.optics,
                look,
                wider[i].tables,
                film.centre[i, k],
                film.rotation[i, k],
                film.lights[i, k],
                others_of(discs[k], i),
                limit,
                tangents,
                whole,
                aim,
            )
        steps.append(solve_bundle(whole, aim, len(look.markers), views))
    spheres = [_changed(s, step) for s, step in zip(known.spheres, steps, strict=True)]
    scales = camera.optics.scales * np.exp(_ratios(steps))
    film.rescale(camera.optics, scales)
    camera = camera.with_scales(scales)
    return replace(known, spheres=(spheres[0], spheres[1]), camera=camera)


def _changed(sphere: Sphere, step: Shared) -> Sphere:
    turns = np.einsum("mt,mtk->mk", step.markers, tangents_of(sphere.markers))
    markers = np.einsum("mij,mj->mi", rotation_matrix(turns), sphere.markers)
    return replace(
        sphere,
        markers=markers,
        alpha=float(np.clip(sphere.alpha + step.alpha, 0.03, 0.6)),
        darkness=float(np.clip(sphere.darkness + step.darkness, 0.05, 1.0)),
    )


def _ratios(steps: list[Shared]) -> Floats:
    """Average the views' scales against the front view's over both spheres, by their errors."""
    logs = np.array([step.log_scale for step in steps])
    weights = np.array([step.log_scale_sigma for step in steps]) ** -2.0
    return np.asarray((weights * logs).sum(axis=0) / weights.sum(axis=0))
