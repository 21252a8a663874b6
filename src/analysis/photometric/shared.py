"""What all frames of a sphere share, solved with each frame's own unknowns eliminated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.photometric.bundle import MARKERS_SHARE, VIEW_SHARE, Lesson, bundle_view
from analysis.photometric.pose import POSE, add_priors, into_world
from analysis.photometric.residual import UNKNOWNS
from analysis.photometric.sight import LIGHTS, Equations, Sight, Stance

Floats = NDArray[np.float64]

MARKER_PRIOR, DARKNESS_PRIOR, ALPHA_PRIOR = 0.2, 0.2, 0.05
RADIUS_PRIOR, BLUR_PRIOR, SCALE_PRIOR, HELD = 0.003, 0.05, 0.05, 1e-9
"""Expected sizes of a correction; radius and blur come from the shading and only take part."""


@dataclass(frozen=True, slots=True, eq=False)
class Shared:
    """Corrections to what the frames of a sphere share, from `solve_shared`.

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


def shared_size(markers: int, views: int) -> int:
    """Return the number of shared unknowns."""
    return 2 * markers + MARKERS_SHARE + VIEW_SHARE * views


def add_frame(sight: Sight, stance: Stance, lesson: Lesson, shared: Equations) -> None:
    """Add one frame to the full equations of the shared unknowns, its own eliminated (Schur)."""
    views, markers = sight.optics.scales.shape[0], sight.look.markers.shape[0]
    common = 2 * markers + MARKERS_SHARE
    local = POSE + LIGHTS * views
    total = local + common + VIEW_SHARE * views
    whole = Equations(np.zeros((total, total)), np.zeros(total))
    size = UNKNOWNS + common + VIEW_SHARE
    for view in range(views):
        own = Equations(np.zeros((size, size)), np.zeros(size))
        bundle_view(sight, stance, view, lesson, own)
        whole_view = own.normal + np.tril(own.normal, -1).T
        change = np.zeros((size, total))
        change[:5, :POSE] = into_world(sight.optics, view)
        for k in range(LIGHTS):
            change[5 + k, POSE + LIGHTS * view + k] = 1.0
        for k in range(common):
            change[UNKNOWNS + k, local + k] = 1.0
        for k in range(VIEW_SHARE):
            change[UNKNOWNS + common + k, local + common + VIEW_SHARE * view + k] = 1.0
        whole.normal[:] += change.T @ whole_view @ change
        whole.right[:] += change.T @ own.right
    add_priors(sight, stance, whole)
    across = whole.normal[:local, local:]
    gain = np.linalg.solve(whole.normal[:local, :local], across)
    shared.normal[:] += whole.normal[local:, local:] - across.T @ gain
    shared.right[:] += whole.right[local:] - gain.T @ whole.right[:local]


def solve_shared(equations: Equations, markers: int, views: int) -> Shared:
    """Solve for the shared unknowns; weak priors hold what no frame determines."""
    prior = np.concatenate(
        [
            np.full(2 * markers, MARKER_PRIOR),
            [DARKNESS_PRIOR, ALPHA_PRIOR],
            [RADIUS_PRIOR, BLUR_PRIOR, HELD],
            np.tile([RADIUS_PRIOR, BLUR_PRIOR, SCALE_PRIOR], views - 1),
        ]
    )
    inverse = np.linalg.inv(equations.normal + np.diag(prior**-2.0))
    step = inverse @ equations.right
    scales = slice(2 * markers + MARKERS_SHARE + VIEW_SHARE - 1, None, VIEW_SHARE)
    return Shared(
        markers=step[: 2 * markers].reshape(markers, 2),
        darkness=float(step[2 * markers]),
        alpha=float(step[2 * markers + 1]),
        log_scale=step[scales],
        log_scale_sigma=np.sqrt(np.diag(inverse)[scales]),
    )


def tangents_of(markers: Floats) -> Floats:
    """Return two unit vectors across each marker, shape (markers, 2, 3)."""
    helper = np.eye(3)[np.abs(markers).argmin(axis=1)]
    first = np.cross(markers, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(markers, first)], axis=1)
