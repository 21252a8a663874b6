"""Marker places, their size and darkness, the disc's radius and the blur, from all frames at once.

The unknowns of each frame (pose, light) are eliminated from its normal equations (Schur
complement), so that what all frames share is solved with its true covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.photometric.camera import Optics, disc_of
from analysis.photometric.compiled import compiled
from analysis.photometric.contour import LAYERS, add_cover
from analysis.photometric.pose import (
    KEEP_OFF_PX,
    LIGHTS,
    POSE,
    Look,
    Scene,
    add_light_prior,
    cover_canvas,
    into_world,
)
from analysis.photometric.residual import (
    LEAST_DISC,
    UNKNOWNS,
    biweight,
    hidden,
    model_pixel,
    pixel_row,
    shade,
)
from analysis.photometric.shading import NUDGE

Floats = NDArray[np.float64]

SHARED = 5
"""Behind the two of each marker: darkness, angular radius, log of the disc's radius, blur,
log of the scale by which the disc stands off the origin."""


VIEW_SHARED = 3


@compiled
def bundle_view(
    scene: Scene,
    optics: Optics,
    look: Look,
    blurred: Floats,
    view: int,
    centre: Floats,
    rotation: Floats,
    light: Floats,
    others: Floats,
    limit: float,
    tangents: Floats,
    normal: Floats,
    right: Floats,
) -> None:
    """Add one view of one frame to the equations of its own and of the shared unknowns.

    Parameters
    ----------
    blurred
        The view's template at a blur NUDGE pixels wider.
    tangents
        Two axes across each marker, body axes, shape (markers, 2, 3).
    normal, right
        Filled: row, column, turns, light, then 2 for each marker and SHARED;
        shapes (n, n) with the lower triangle, and (n,).
    """
    place = disc_of(optics, view, centre, look.radius_m)
    shape = (scene.image.shape[0], scene.image.shape[1])
    axes = optics.axes[view]
    directions = (look.markers @ rotation.T) @ axes.T
    canvas, corner = cover_canvas(look, view, directions, place, shape)
    bigger = (place[0], place[1], place[2] * (1.0 + NUDGE))
    sigma = look.sigma_px[view]
    rows, columns = canvas.shape[1], canvas.shape[2]
    at_radius, at_blur = np.zeros((LAYERS, rows, columns)), np.zeros((LAYERS, rows, columns))
    at_alpha = np.zeros((LAYERS, rows, columns))
    count = directions.shape[0]
    own = np.zeros((count, LAYERS, rows, columns))
    for m in range(count):
        add_cover(own[m], corner, place, directions[m], look.alpha, sigma)
        add_cover(at_alpha, corner, place, directions[m], look.alpha + NUDGE, sigma)
        add_cover(at_radius, corner, bigger, directions[m], look.alpha, sigma)
        add_cover(at_blur, corner, place, directions[m], look.alpha, sigma + NUDGE)
    turns = np.zeros((count, 2, 3))
    for m in range(count):
        for t in range(2):
            turns[m, t] = optics.hands[view] * (axes @ (rotation @ tangents[m, t]))
    out_r, out_c = place[0] - optics.origins[view, 0], place[1] - optics.origins[view, 1]
    size = UNKNOWNS + 2 * count + SHARED
    row, look_up, nudged = np.zeros(size), np.zeros(12), np.zeros(12)
    used = np.zeros(size, dtype=np.int64)
    first = UNKNOWNS + 2 * count
    for i in range(rows):
        y = corner[0] + i
        if y < optics.rows[view, 0] or y >= optics.rows[view, 1]:
            continue
        u = (y - place[0]) / place[2]
        for j in range(columns):
            x = corner[1] + j
            v = (x - place[1]) / place[2]
            if not shade(look.tables[view], look.reliefs[view], u, v, look_up) or hidden(
                y, x, others, KEEP_OFF_PX
            ):
                continue
            behind = scene.background[y, x]
            model = pixel_row(look_up, canvas, i, j, behind, light, look.darkness, place[2], row)
            residual = scene.image[y, x] - model
            weight = biweight(residual, limit * scene.noise)
            if weight == 0.0:
                continue
            weight /= scene.noise**2
            disc = max(look_up[3], LEAST_DISC)
            plain = light[1] * look_up[0] + light[2] * look_up[6] + light[3] * look_up[9]
            for k in range(UNKNOWNS):
                used[k] = k
            filled = UNKNOWNS
            for m in range(count):
                if own[m, 0, i, j] == 0.0:
                    continue
                for t in range(2):
                    change = 0.0
                    for k in range(3):
                        change += own[m, 3 + k, i, j] * turns[m, t, k]
                    row[UNKNOWNS + 2 * m + t] = -plain * look.darkness / disc * change
                    used[filled] = UNKNOWNS + 2 * m + t
                    filled += 1
            row[first] = -plain * canvas[0, i, j] / disc
            there = model_pixel(look_up, at_alpha[0, i, j], behind, light, look.darkness)
            row[first + 1] = (there - model) / NUDGE
            shade(
                look.tables[view], look.reliefs[view], u / (1.0 + NUDGE), v / (1.0 + NUDGE), nudged
            )
            there = model_pixel(nudged, at_radius[0, i, j], behind, light, look.darkness)
            row[first + 2] = (there - model) / NUDGE
            row[first + 4] = row[0] * out_r + row[1] * out_c
            shade(blurred, look.reliefs[view], u, v, nudged)
            there = model_pixel(nudged, at_blur[0, i, j], behind, light, look.darkness)
            row[first + 3] = (there - model) / NUDGE
            for k in range(SHARED):
                used[filled] = first + k
                filled += 1
            for a in range(filled):
                p = used[a]
                scaled = weight * row[p]
                right[p] += scaled * residual
                for b in range(a + 1):
                    normal[p, used[b]] += scaled * row[used[b]]


@dataclass(frozen=True, slots=True, eq=False)
class Shared:
    """Corrections to what the frames of a sphere share, from `solve_bundle`.

    Attributes
    ----------
    markers
        Turns about the two tangents of each marker, radians, shape (markers, 2).
    darkness, alpha
        Of the markers.
    log_scale, log_scale_sigma
        Of each view's scale against the front view's, as the tracks have it, shape (V,).
    """

    markers: Floats
    darkness: float
    alpha: float
    log_scale: Floats
    log_scale_sigma: Floats


@compiled
def bundle_frame(
    scene: Scene,
    optics: Optics,
    look: Look,
    blurred: Floats,
    centre: Floats,
    rotation: Floats,
    lights: Floats,
    others: Floats,
    limit: float,
    tangents: Floats,
    whole: Floats,
    aim: Floats,
) -> None:
    """Add one frame to the equations of the shared unknowns, its own unknowns eliminated.

    Parameters
    ----------
    whole, aim
        Added to: 2 for each marker, darkness, alpha, then log radius and blur of each view.
    """
    views, markers = optics.scales.shape[0], look.markers.shape[0]
    shared = 2 * markers + 2 + VIEW_SHARED * views
    local = POSE + LIGHTS * views
    normal, right = np.zeros((local + shared, local + shared)), np.zeros(local + shared)
    size = UNKNOWNS + 2 * markers + SHARED
    for view in range(views):
        own, own_right = np.zeros((size, size)), np.zeros(size)
        bundle_view(
            scene,
            optics,
            look,
            blurred[view],
            view,
            centre,
            rotation,
            lights[view],
            others[view],
            limit,
            tangents,
            own,
            own_right,
        )
        for a in range(size):
            for b in range(a):
                own[b, a] = own[a, b]
        change = np.zeros((size, local + shared))
        change[:5, :POSE] = into_world(optics, view)
        for k in range(LIGHTS):
            change[5 + k, POSE + LIGHTS * view + k] = 1.0
        for k in range(2 * markers + 2):
            change[UNKNOWNS + k, local + k] = 1.0
        for k in range(VIEW_SHARED):
            at = local + 2 * markers + 2 + VIEW_SHARED * view + k
            change[UNKNOWNS + 2 * markers + 2 + k, at] = 1.0
        normal += change.T @ own @ change
        right += change.T @ own_right
        add_light_prior(lights[view], POSE + LIGHTS * view, normal, right)
    for k in range(3):
        normal[k, k] += 1e-6 / look.radius_m**2
        normal[3 + k, 3 + k] += 1e-6
    gain = np.linalg.solve(normal[:local, :local], normal[:local, local:])
    whole += normal[local:, local:] - np.ascontiguousarray(normal[local:, :local]) @ gain
    aim += right[local:] - gain.T @ right[:local]


MARKER_PRIOR, DARKNESS_PRIOR, ALPHA_PRIOR = 0.2, 0.2, 0.05
RADIUS_PRIOR, BLUR_PRIOR, SCALE_PRIOR, HELD = 0.003, 0.05, 0.05, 1e-9
"""Expected sizes of a correction; radius and blur come from the shading and only take part."""


def solve_bundle(whole: Floats, aim: Floats, markers: int, views: int) -> Shared:
    """Solve for the shared unknowns; weak priors hold what no frame determines."""
    own = [RADIUS_PRIOR, BLUR_PRIOR, SCALE_PRIOR]
    prior = np.concatenate(
        [
            np.full(2 * markers, MARKER_PRIOR),
            [DARKNESS_PRIOR, ALPHA_PRIOR],
            [RADIUS_PRIOR, BLUR_PRIOR, HELD],
            np.tile(own, views - 1),
        ]
    )
    inverse = np.linalg.inv(whole + np.diag(prior**-2.0))
    step = inverse @ aim
    last = slice(2 * markers + 2 + VIEW_SHARED - 1, None, VIEW_SHARED)
    return Shared(
        markers=step[: 2 * markers].reshape(markers, 2),
        darkness=float(step[2 * markers]),
        alpha=float(step[2 * markers + 1]),
        log_scale=step[last],
        log_scale_sigma=np.sqrt(np.diag(inverse)[last]),
    )


def tangents_of(markers: Floats) -> Floats:
    """Return two unit vectors across each marker, shape (markers, 2, 3)."""
    helper = np.eye(3)[np.abs(markers).argmin(axis=1)]
    first = np.cross(markers, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(markers, first)], axis=1)
