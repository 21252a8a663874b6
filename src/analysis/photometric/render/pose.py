"""One sphere in one frame: Gauss-Newton steps for its pose, all views together."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.motion.turning import turned
from analysis.photometric.render.accumulation import accumulate
from analysis.photometric.render.camera import Optics, axes_at, moved_by
from analysis.photometric.render.residual import UNKNOWNS
from analysis.photometric.render.sight import (
    LIGHTS,
    Equations,
    Reel,
    Sight,
    Stance,
    reel_of,
    sight_at,
)

POSE = 6
ONLY = np.zeros(1, dtype=np.intp)
"""The frame of a reel of one."""
LONGEST_STEP, LONGEST_TURN = 0.3, 0.15
"""Of one iteration, in radii and radians."""
PRIOR_OFFSET, PRIOR_GAIN, PRIOR_SLOPE = 20.0, 0.3, 20.0
"""Widths that keep a view's light determined where few of its pixels are seen."""
LEAST_SEEN = 0.35
"""Least pixels of a view over those of the view that shows most: a remainder beside another sphere
in the mirror lies in that one's shadow and biases the pose."""
WIDEST_PLACE, WIDEST_TURN = 10.0, 4.0
"""Errors, in radii and radians, that are stated where no pixel shows a direction or a turn."""


@compiled
def into_world(optics: Optics, view: int, centre: Floats) -> Floats:
    """Return the derivative of a view's row, column and turns to centre and turn, shape (5, 6)."""
    change = np.zeros((5, POSE))
    axes, moved = axes_at(optics, view, centre), moved_by(optics, view, centre)
    for k in range(3):
        for a in range(2):
            change[a, k] = moved[a, k]
        for a in range(3):
            change[2 + a, 3 + k] = optics.hands[view] * axes[a, k]
    return change


@part
def add_turned(own: Equations, change: Floats, at: int, whole: Equations) -> None:
    """Add one view's equations to those of pose and light.

    Parameters
    ----------
    own
        Of the view's UNKNOWNS.
    change
        Of `into_world`.
    at
        Index of the view's light in the whole.
    """
    half = np.zeros((UNKNOWNS, POSE))
    for a in range(UNKNOWNS):
        for b in range(5):
            product = own.normal[max(a, b), min(a, b)]
            for p in range(POSE):
                half[a, p] += product * change[b, p]
    for p in range(POSE):
        for a in range(5):
            whole.right[p] += change[a, p] * own.right[a]
            for q in range(p + 1):
                whole.normal[p, q] += change[a, p] * half[a, q]
        for k in range(LIGHTS):
            whole.normal[at + k, p] += half[5 + k, p]
    for k in range(LIGHTS):
        whole.right[at + k] += own.right[5 + k]
        for n in range(k + 1):
            whole.normal[at + k, at + n] += own.normal[5 + k, 5 + n]


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


@part
def inverse_of(normal: Floats) -> Floats:
    """Return the inverse of a positive definite matrix given by its lower triangle (Cholesky)."""
    size = normal.shape[0]
    root, inverse = np.zeros((size, size)), np.zeros((size, size))
    for a in range(size):
        for b in range(a + 1):
            left = normal[a, b]
            for k in range(b):
                left -= root[a, k] * root[b, k]
            root[a, b] = math.sqrt(left) if a == b else left / root[b, b]
    for a in range(size):
        inverse[a, a] = 1.0 / root[a, a]
        for b in range(a):
            total = 0.0
            for k in range(b, a):
                total += root[a, k] * inverse[k, b]
            inverse[a, b] = -total / root[a, a]
    whole = np.zeros((size, size))
    for a in range(size):
        for b in range(a + 1):
            for k in range(a, size):
                whole[a, b] += inverse[k, a] * inverse[k, b]
            whole[b, a] = whole[a, b]
    return whole


@part
def add_views(sight: Sight, stance: Stance, limit: float, whole: Equations, out: Floats) -> None:
    """Add the equations of all views that show enough of the sphere.

    Parameters
    ----------
    out
        Its first three are filled: weighted chi-squared, weights, pixels looked at.
    """
    views = sight.optics.scales.shape[0]
    normal, right = np.zeros((views, UNKNOWNS, UNKNOWNS)), np.zeros((views, UNKNOWNS))
    sums = np.zeros((views, 3))
    for view in range(views):
        own = Equations(normal[view], right[view])
        sums[view, 0], sums[view, 1], sums[view, 2] = accumulate(sight, stance, view, limit, own)
    out[0], out[1], out[2] = 0.0, 0.0, 0.0
    for view in range(views):
        if sums[view, 2] < LEAST_SEEN * sums[:, 2].max():
            continue
        for k in range(3):
            out[k] += sums[view, k]
        change = into_world(sight.optics, view, stance.centre)
        own = Equations(normal[view], right[view])
        add_turned(own, change, POSE + LIGHTS * view, whole)


@part
def take_steps(sight: Sight, stance: Stance, limits: Floats, covariance: Floats) -> Floats:
    """Improve a stance in place, as `fit_pose` describes."""
    views = sight.optics.scales.shape[0]
    size = POSE + LIGHTS * views
    step, out = np.zeros(size), np.zeros(5)
    for limit in limits:
        whole = Equations(np.zeros((size, size)), np.zeros(size))
        add_views(sight, stance, limit, whole, out)
        add_priors(sight, stance, whole)
        inverse = inverse_of(whole.normal)
        for a in range(size):
            step[a] = 0.0
            for b in range(size):
                step[a] += inverse[a, b] * whole.right[b]
        out[3], out[4] = move(stance, step, sight.look.radius_m)
        for a in range(POSE):
            for b in range(POSE):
                covariance[a, b] = inverse[a, b]
    return out


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
    reel = reel_of(sight, stance)
    fit_frames(reel, ONLY, limits)
    covariance[:] = reel.covariance[0]
    only: Floats = reel.quality[0]
    return only


@part
def move(stance: Stance, step: Floats, radius_m: float) -> tuple[float, float]:
    """Add a step to pose and light; return its length in radii and in radians.

    A pose moves by LONGEST_STEP and LONGEST_TURN at most.
    """
    length, turn = 0.0, 0.0
    for k in range(3):
        length += (step[k] / radius_m) ** 2
        turn += step[3 + k] ** 2
    length, turn = math.sqrt(length), math.sqrt(turn)
    near = min(1.0, LONGEST_STEP / max(length, 1e-12))
    little = min(1.0, LONGEST_TURN / max(turn, 1e-12))
    for k in range(3):
        stance.centre[k] += near * step[k]
    for k in range(3, POSE):
        step[k] *= little
    result = turned(step[3:POSE], stance.rotation)
    for a in range(3):
        for b in range(3):
            stance.rotation[a, b] = result[a, b]
    for view in range(stance.lights.shape[0]):
        for k in range(LIGHTS):
            stance.lights[view, k] += step[POSE + LIGHTS * view + k]
    return length, turn


@compiled
def fit_frames(reel: Reel, frames: NDArray[np.intp], limits: Floats) -> None:
    """Improve the poses of some frames of a reel, each by `fit_pose`."""
    for k in frames:
        sight, stance = sight_at(reel, k)
        out = take_steps(sight, stance, limits, reel.covariance[k])
        for n in range(out.shape[0]):
            reel.quality[k, n] = out[n]
