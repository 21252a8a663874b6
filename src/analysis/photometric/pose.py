"""One sphere in one frame: Gauss-Newton steps for its pose, all views together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.photometric.camera import Optics
from analysis.photometric.compiled import compiled
from analysis.photometric.residual import UNKNOWNS, accumulate
from analysis.photometric.sight import LIGHTS, Equations, Sight, Stance

Floats = NDArray[np.float64]

POSE = 6
LONGEST_STEP, LONGEST_TURN = 0.3, 0.15
"""Of one iteration, in radii and radians."""
PRIOR_OFFSET, PRIOR_GAIN, PRIOR_SLOPE = 20.0, 0.3, 20.0
"""Widths that keep a view's light determined where few of its pixels are seen."""
WIDEST_PLACE, WIDEST_TURN = 10.0, 4.0
"""Errors, in radii and radians, that are stated where no pixel shows a direction or a turn."""


@compiled
def into_world(optics: Optics, view: int) -> Floats:
    """Return the derivative of a view's row, column and turns to centre and turn, shape (5, 6)."""
    change = np.zeros((5, POSE))
    change[:2, :3] = optics.scales[view] * optics.axes[view, :2]
    change[2:, 3:] = optics.hands[view] * optics.axes[view]
    return change


@compiled
def add_view(sight: Sight, stance: Stance, view: int, limit: float, whole: Equations) -> Floats:
    """Add one view to the equations of pose and light; return what `accumulate` returns."""
    own = Equations(np.zeros((UNKNOWNS, UNKNOWNS)), np.zeros(UNKNOWNS))
    squares, weights, count = accumulate(sight, stance, view, limit, own)
    for a in range(UNKNOWNS):
        for b in range(a):
            own.normal[b, a] = own.normal[a, b]
    change = np.zeros((UNKNOWNS, POSE + LIGHTS))
    change[:5, :POSE] = into_world(sight.optics, view)
    for k in range(LIGHTS):
        change[5 + k, POSE + k] = 1.0
    part, right = change.T @ own.normal @ change, change.T @ own.right
    at = POSE + LIGHTS * view
    whole.normal[:POSE, :POSE] += part[:POSE, :POSE]
    whole.normal[at : at + LIGHTS, at : at + LIGHTS] += part[POSE:, POSE:]
    whole.normal[:POSE, at : at + LIGHTS] += part[:POSE, POSE:]
    whole.normal[at : at + LIGHTS, :POSE] += part[POSE:, :POSE]
    whole.right[:POSE] += right[:POSE]
    whole.right[at : at + LIGHTS] += right[POSE:]
    return np.array([squares, weights, float(count)])


@compiled
def pose_equations(sight: Sight, stance: Stance, limit: float, whole: Equations) -> Floats:
    """Fill the full normal equations of pose and light over all views.

    Returns
    -------
    Weighted squares over the variance, weights, and pixels looked at, shape (3,).
    """
    whole.normal[:], whole.right[:] = 0.0, 0.0
    totals = np.zeros(3)
    for view in range(sight.optics.scales.shape[0]):
        totals += add_view(sight, stance, view, limit, whole)
    add_priors(sight, stance, whole)
    return totals


@compiled
def add_priors(sight: Sight, stance: Stance, whole: Equations) -> None:
    """Tie the light weakly to no offset, gain 1 and no slope, and what is unseen to its place."""
    for k in range(3):
        whole.normal[k, k] += 1.0 / (WIDEST_PLACE * sight.look.radius_m) ** 2
        whole.normal[3 + k, 3 + k] += 1.0 / WIDEST_TURN**2
    for view in range(stance.lights.shape[0]):
        at = POSE + LIGHTS * view
        for k in range(LIGHTS):
            width = PRIOR_OFFSET if k == 0 else (PRIOR_GAIN if k == 1 else PRIOR_SLOPE)
            expected = 1.0 if k == 1 else 0.0
            whole.normal[at + k, at + k] += 1.0 / width**2
            whole.right[at + k] += (expected - stance.lights[view, k]) / width**2


@compiled
def turned(vector: Floats, rotation: Floats) -> Floats:
    """Return exp([vector]) rotation."""
    angle = np.sqrt((vector**2).sum())
    x, y, z = vector[0], vector[1], vector[2]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    one = np.sin(angle) / angle if angle > 1e-9 else 1.0
    two = (1 - np.cos(angle)) / angle**2 if angle > 1e-5 else 0.5
    result: Floats = (np.eye(3) + one * cross + two * (cross @ cross)) @ rotation
    return result


@compiled
def fit_pose(sight: Sight, stance: Stance, limits: Floats, covariance: Floats) -> Floats:
    """Improve a stance in place, one Gauss-Newton step for each limit.

    Parameters
    ----------
    limits
        Residual that counts no more in each step, in units of the noise.
    covariance
        Filled with that of centre and turn, before the last step, shape (6, 6).

    Returns
    -------
    Weighted chi-squared, weights, pixels looked at, and the last step's length in radii and
    radians, shape (5,).
    """
    size = POSE + LIGHTS * sight.optics.scales.shape[0]
    whole, out = Equations(np.zeros((size, size)), np.zeros(size)), np.zeros(5)
    for limit in limits:
        out[:3] = pose_equations(sight, stance, limit, whole)
        inverse = np.linalg.inv(whole.normal)
        step = inverse @ whole.right
        length = np.sqrt((step[:3] ** 2).sum()) / sight.look.radius_m
        turn = np.sqrt((step[3:6] ** 2).sum())
        step[:3] *= min(1.0, LONGEST_STEP / max(length, 1e-12))
        step[3:6] *= min(1.0, LONGEST_TURN / max(turn, 1e-12))
        stance.centre[:] += step[:3]
        stance.rotation[:] = turned(step[3:6], stance.rotation)
        for view in range(stance.lights.shape[0]):
            stance.lights[view] += step[POSE + LIGHTS * view : POSE + LIGHTS * (view + 1)]
        covariance[:] = inverse[:6, :6]
        out[3], out[4] = length, turn
    return out
