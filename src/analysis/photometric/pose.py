"""One sphere in one frame: Gauss-Newton steps for its pose, all views together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.photometric.camera import Optics, disc_of
from analysis.photometric.compiled import compiled
from analysis.photometric.contour import LAYERS, add_cover
from analysis.photometric.residual import UNKNOWNS, accumulate

Floats = NDArray[np.float64]

LIGHTS = 4
POSE = 6
AROUND_PX = 4
KEEP_OFF_PX = 2.6
"""Another disc's blurred edge reaches this far."""
LONGEST_STEP, LONGEST_TURN = 0.3, 0.15
"""Of one iteration, in radii and radians."""
PRIOR_OFFSET, PRIOR_GAIN, PRIOR_SLOPE = 20.0, 0.3, 20.0
"""Widths that keep a view's light determined where few of its pixels are seen."""


class Look(NamedTuple):
    """How a sphere looks, as compiled functions take it.

    Attributes
    ----------
    radius_m
        Of the sphere.
    markers
        Directions in body axes, shape (markers, 3).
    alpha
        Angular radius of a marker, radians.
    darkness
        Share of the light that a marker swallows.
    tables
        Template of each view, shape (V, steps, columns).
    reliefs
        What the template leaves, in each view, shape (V, n, n).
    sigma_px
        Standard deviation of the blur in each view.
    """

    radius_m: float
    markers: Floats
    alpha: float
    darkness: float
    tables: Floats
    reliefs: Floats
    sigma_px: Floats


class Scene(NamedTuple):
    """One frame and what surrounds a sphere in it.

    Attributes
    ----------
    image
        Grey levels, shape (rows, columns).
    background
        Grey levels without spheres, same shape.
    noise
        Standard deviation of a pixel, grey levels.
    """

    image: NDArray[np.uint8]
    background: Floats
    noise: float


@compiled
def window(place: tuple[float, float, float], shape: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the half-open rows and columns of a disc and its surroundings within a frame."""
    reach = place[2] + AROUND_PX
    first_r = min(max(int(place[0] - reach), 0), shape[0])
    last_r = max(min(int(place[0] + reach) + 2, shape[0]), first_r)
    first_c = min(max(int(place[1] - reach), 0), shape[1])
    last_c = max(min(int(place[1] + reach) + 2, shape[1]), first_c)
    return first_r, last_r, first_c, last_c


@compiled
def cover_canvas(
    look: Look,
    view: int,
    directions: Floats,
    place: tuple[float, float, float],
    shape: tuple[int, int],
) -> tuple[Floats, tuple[int, int]]:
    """Draw the covers of all markers, directions (markers, 3) as the view sees them."""
    first_r, last_r, first_c, last_c = window(place, shape)
    canvas = np.zeros((LAYERS, last_r - first_r, last_c - first_c))
    for m in range(directions.shape[0]):
        add_cover(canvas, (first_r, first_c), place, directions[m], look.alpha, look.sigma_px[view])
    return canvas, (first_r, first_c)


@compiled
def into_world(optics: Optics, view: int) -> Floats:
    """Return the derivative of a view's row, column and turns to centre and turn, shape (5, 6)."""
    change = np.zeros((5, POSE))
    change[:2, :3] = optics.scales[view] * optics.axes[view, :2]
    change[2:, 3:] = optics.hands[view] * optics.axes[view]
    return change


@compiled
def pose_equations(
    scene: Scene,
    optics: Optics,
    look: Look,
    centre: Floats,
    rotation: Floats,
    lights: Floats,
    others: Floats,
    limit: float,
    normal: Floats,
    right: Floats,
) -> Floats:
    """Fill the normal equations of pose and light over all views.

    Parameters
    ----------
    others
        For each view the other discs of the frame, shape (V, others, 3).
    limit
        Residual that counts no more, in units of the noise.
    normal, right
        Filled, in units of 1: shapes (n, n) and (n,) with n = POSE + LIGHTS V.

    Returns
    -------
    Weighted squares over the variance, weights, and pixels looked at, shape (3,).
    """
    normal[:], right[:] = 0.0, 0.0
    totals = np.zeros(3)
    variance = scene.noise**2
    shape = (scene.image.shape[0], scene.image.shape[1])
    own, own_right = np.zeros((UNKNOWNS, UNKNOWNS)), np.zeros(UNKNOWNS)
    change = np.zeros((UNKNOWNS, POSE + LIGHTS))
    for k in range(LIGHTS):
        change[5 + k, POSE + k] = 1.0
    for view in range(optics.scales.shape[0]):
        place = disc_of(optics, view, centre, look.radius_m)
        directions = (look.markers @ rotation.T) @ optics.axes[view].T
        canvas, corner = cover_canvas(look, view, directions, place, shape)
        own[:], own_right[:] = 0.0, 0.0
        squares, weights, count = accumulate(
            scene.image,
            scene.background,
            (optics.rows[view, 0], optics.rows[view, 1]),
            canvas,
            corner,
            place,
            (look.tables[view], look.reliefs[view]),
            lights[view],
            look.darkness,
            others[view],
            KEEP_OFF_PX,
            limit * scene.noise,
            own,
            own_right,
        )
        totals[0] += squares / variance
        totals[1] += weights
        totals[2] += count
        for a in range(UNKNOWNS):
            for b in range(a):
                own[b, a] = own[a, b]
        change[:5, :POSE] = into_world(optics, view)
        part = change.T @ own @ change / variance
        part_right = change.T @ own_right / variance
        at = POSE + LIGHTS * view
        normal[:POSE, :POSE] += part[:POSE, :POSE]
        normal[at : at + LIGHTS, at : at + LIGHTS] += part[POSE:, POSE:]
        normal[:POSE, at : at + LIGHTS] += part[:POSE, POSE:]
        normal[at : at + LIGHTS, :POSE] += part[POSE:, :POSE]
        right[:POSE] += part_right[:POSE]
        right[at : at + LIGHTS] += part_right[POSE:]
        add_light_prior(lights[view], at, normal, right)
    return totals


@compiled
def add_light_prior(light: Floats, at: int, normal: Floats, right: Floats) -> None:
    """Tie a view's light weakly to no offset, gain 1 and no slope."""
    for k in range(LIGHTS):
        width = PRIOR_OFFSET if k == 0 else (PRIOR_GAIN if k == 1 else PRIOR_SLOPE)
        expected = 1.0 if k == 1 else 0.0
        normal[at + k, at + k] += 1.0 / width**2
        right[at + k] += (expected - light[k]) / width**2


@compiled
def turned(vector: Floats, rotation: Floats) -> Floats:
    """Return exp([vector]) rotation."""
    angle = np.sqrt((vector**2).sum())
    x, y, z = vector[0], vector[1], vector[2]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    one = np.sin(angle) / angle if angle > 1e-9 else 1.0
    two = (1 - np.cos(angle)) / angle**2 if angle > 1e-5 else 0.5
    return (np.eye(3) + one * cross + two * (cross @ cross)) @ rotation


@compiled
def fit_pose(
    scene: Scene,
    optics: Optics,
    look: Look,
    centre: Floats,
    rotation: Floats,
    lights: Floats,
    others: Floats,
    limits: Floats,
    covariance: Floats,
) -> Floats:
    """Improve a pose in place, one Gauss-Newton step for each limit.

    Parameters
    ----------
    centre, rotation, lights
        Start, and result: m and rig axes, body to rig axes, shapes (3,), (3, 3), (V, LIGHTS).
    limits
        Residual that counts no more in each step, in units of the noise.
    covariance
        Filled with that of centre and turn, before the last step, shape (6, 6).

    Returns
    -------
    Weighted chi-squared, weights, pixels looked at, and the last step's length in radii and
    radians, shape (5,).
    """
    size = POSE + LIGHTS * optics.scales.shape[0]
    normal, right, out = np.zeros((size, size)), np.zeros(size), np.zeros(5)
    for limit in limits:
        out[:3] = pose_equations(
            scene, optics, look, centre, rotation, lights, others, limit, normal, right
        )
        # Unseen directions (no markers, one view) stay where they are.
        for k in range(3):
            normal[k, k] += 1e-6 / look.radius_m**2
            normal[3 + k, 3 + k] += 1e-6
        inverse = np.linalg.inv(normal)
        step = inverse @ right
        length = np.sqrt((step[:3] ** 2).sum()) / look.radius_m
        turn = np.sqrt((step[3:6] ** 2).sum())
        step[:3] *= min(1.0, LONGEST_STEP / max(length, 1e-12))
        step[3:6] *= min(1.0, LONGEST_TURN / max(turn, 1e-12))
        centre += step[:3]
        rotation[:] = turned(step[3:6], rotation)
        for view in range(lights.shape[0]):
            lights[view] += step[POSE + LIGHTS * view : POSE + LIGHTS * (view + 1)]
        covariance[:] = inverse[:6, :6]
        out[3], out[4] = length, turn
    return out
