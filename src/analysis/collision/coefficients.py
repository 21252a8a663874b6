"""From motion on both sides to the impact, each number with its standard error."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.derivative import derivative
from analysis.collision.impact import ContactState, impact_velocities
from analysis.collision.instant import NoTouchError, parting_time, touching_time
from analysis.collision.operator import Body
from analysis.collision.unseen_depth import UnseenDepth
from analysis.motion.spin import Spin
from analysis.motion.velocity import FlightPath
from analysis.quantity import Quantity

HELD = 2
"""Of the shared errors, those that the covariance holds."""
VELOCITIES, STATES = slice(4, 8), slice(10, 34)
"""Where v_n, v_s, v_n', v_s' and where both states stand among the outcomes."""
BETA_NEEDS_SIGMAS = 3.0
"""Below this many standard errors of v_s its ratio has no meaning and is not given."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Motion of one sphere on both sides of the contact, paths at one reference time.

    A spin is None where there are too few orientations.
    """

    before: FlightPath
    after: FlightPath
    spin_before: Spin | None
    spin_after: Spin | None


@dataclass(frozen=True, slots=True, eq=False)
class Impact:
    """A measured collision.

    Attributes
    ----------
    contact_time
        First touch, s from the shot's first frame.
    duration
        From first touch on the paths before contact to the parting on those after it, s; None where
        the latter pass each other by. An instantaneous contact has 0 within its error. Straight
        lines through the tracks cross e / (1 + e) of it after first touch: that is their kink.
    normal, normal_sigma
        Unit vector from a to b at first touch and its standard errors, rig axes, shape (3,).
    v_n, v_s, v_n_after, v_s_after
        Section 7.1; v_n negative, v_n_after positive, v_s a length, v_s_after along it. Surface
        velocities are None where a spin is undetermined.
    e, beta
        Restitution; beta is None where v_s is compatible with zero.
    covariance
        Of v_n, v_s, v_n_after and v_s_after, (m/s)^2, shape (4, 4).
    shared
        What one standard error of each thing that all shots of a campaign share does to these four,
        m/s, shape (5, 4): of the scale, of the air's drag, and of one sphere's outlines against the
        other's along X, Y and Z. The covariance holds the first two (`HELD`), and the outlines'
        offset as an error of each shot.
    before, after
        State just before and just after contact; an undetermined spin is not a number.
    state_sigma
        Standard errors of velocities (m/s) and spins (rad/s), before and after, shape (2, 4, 3)
        in the order velocity a, velocity b, spin a, spin b.
    """

    contact_time: Quantity
    duration: Quantity | None
    normal: Floats
    normal_sigma: Floats
    v_n: Quantity
    v_s: Quantity | None
    v_n_after: Quantity
    v_s_after: Quantity | None
    e: Quantity
    beta: Quantity | None
    covariance: Floats
    shared: Floats
    before: ContactState
    after: ContactState
    state_sigma: Floats


def first_touch(a: FlightPath, b: FlightPath, radii: tuple[float, float]) -> float:
    """Return the time of first touch on the paths before contact, s from the first frame.

    Raises
    ------
    NoTouchError
        The paths do not touch.
    """
    separation, relative = b.position - a.position, b.velocity - a.velocity
    return a.reference_s + float(_wait(separation, relative, np.array(sum(radii))))


def touch_with_error(
    a: FlightPath, b: FlightPath, radii: tuple[float, float], lasting_m: float, scale_sigma: float
) -> tuple[float, float]:
    """Return the time of first touch, s from the first frame, and its standard error.

    Parameters
    ----------
    lasting_m
        Standard error along each axis that a sphere's places have in all frames.
    scale_sigma
        Relative standard error of the scale.

    Raises
    ------
    NoTouchError
        The paths do not touch.
    """
    touch = first_touch(a, b, radii)
    (at_a, v_a), (at_b, v_b) = a.at(touch), b.at(touch)
    normal = (at_b - at_a) / np.linalg.norm(at_b - at_a)
    places = a.covariance[:3, :3] + b.covariance[:3, :3]
    along = float(normal @ places @ normal) + 2.0 * lasting_m**2 + (sum(radii) * scale_sigma) ** 2
    return touch, math.sqrt(along) / abs(float((v_b - v_a) @ normal))


def _wait(separation: Floats, relative: Floats, distance: Floats) -> Floats:
    """Return the times to the touch of one pair or many.

    Raises
    ------
    NoTouchError
        One of them does not touch.
    """
    wait = touching_time(separation, relative, distance)
    if np.isnan(wait).any():
        square = (relative**2).sum(axis=-1, keepdims=True)
        along = (separation * relative).sum(axis=-1, keepdims=True)
        nearest = separation - relative * along / square
        raise NoTouchError(float(np.linalg.norm(nearest, axis=-1).max()))
    return wait


def measure_impact(
    a: Motion,
    b: Motion,
    radii: tuple[float, float],
    scale_sigma: float,
    *,
    offset_sigma: float = 0.0,
    held_sigma: float = math.inf,
    turn_sigma: float = 0.0,
    without_depth: tuple[Body, Body] | None = None,
) -> Impact:
    """Combine the motions of both spheres into the impact.

    The normal is taken at first touch on the incoming paths, not where the tracks have their
    kink: a contact of finite length turns it (P. Mueller and T. Poeschel, Granular Matter 14, 115
    (2012)). Errors follow from those of the paths, the spins, the scale and the drag of the air by
    the derivative of the whole calculation.

    Parameters
    ----------
    a, b
        All paths with one reference time near the contact.
    radii
        Of a and b, m.
    scale_sigma
        Relative standard error of the scale, common to all lengths.
    offset_sigma
        Standard error of the centres of b against those of a along each axis, m, before and after
        contact alike.
    held_sigma
        How much of it the errors of each flight hold already.
    turn_sigma
        Standard error, rad, by which all orientations of a sphere are seen turned about each axis,
        before and after contact alike; its spins are seen turned with them (decision 0039).
    without_depth
        What collided, where Z was not measured: its velocity after contact follows from the spins,
        and what it may be besides is among the errors (`unseen_depth`).

    Raises
    ------
    NoTouchError
        The paths before contact do not touch.
    """
    parts = (a.before, b.before, a.after, b.after)
    spins = (a.spin_before, b.spin_before, a.spin_after, b.spin_after)
    centre = np.concatenate(
        [np.concatenate([p.position, p.velocity]) for p in parts]
        + [np.zeros(3) if s is None else s.velocity for s in spins]
        + [np.ones(1)]
    )
    own = _block_diagonal(
        [p.covariance for p in parts]
        + [np.zeros((3, 3)) if s is None else s.covariance for s in spins]
        + [np.zeros((1, 1))]
    )
    # Drag slows all four paths together, and the scale is one for all lengths.
    common = np.zeros((HELD + 3, len(centre)))
    common[0, -1] = scale_sigma
    common[1, :24] = np.concatenate([p.drag_shift for p in parts])
    for axis in range(3):
        common[HELD + axis, [6 + axis, 18 + axis]] = offset_sigma
    unheld = np.sqrt(max(1.0 - (held_sigma / offset_sigma) ** 2, 0.0)) if offset_sigma else 0.0
    beside = np.concatenate(
        [common[:HELD], unheld * common[HELD:], turn_sigma * _seen_turned(centre)]
    )
    covariance = own + beside.T @ beside
    accelerations = np.array([p.acceleration for p in parts])
    determined = np.array([s is not None for s in spins])
    unseen = None
    if without_depth is not None:
        unseen = UnseenDepth(without_depth, determined[:2] & determined[2:])

    def outcomes(states: Floats) -> Floats:
        return _outcomes(states, a.before.reference_s, accelerations, radii, unseen)

    if unseen is not None:
        covariance = covariance + unseen.scatter(outcomes(centre[None])[0])
        centre, covariance, common = unseen.shown(outcomes, centre, covariance, common)
    jacobian = derivative(outcomes, centre, np.sqrt(np.diag(covariance)))
    spread = jacobian @ covariance @ jacobian.T
    if unseen is not None:
        spread += unseen.bend(outcomes, centre, covariance, jacobian)
    return _named(outcomes(centre[None])[0], spread, common @ jacobian.T, determined)


def _outcomes(
    states: Floats,
    reference: float,
    accelerations: Floats,
    radii: tuple[float, float],
    unseen: UnseenDepth | None,
) -> Floats:
    """Return time, normal (3), v_n, v_s, v_n', v_s', e, beta, both states (24 numbers), duration.

    Parameters
    ----------
    states
        Positions and velocities of the four paths, four spins, and the scale, shape (n, 37).
    accelerations
        Of the four paths, m/s^2, shape (4, 3).

    Returns
    -------
    Shape (n, 35); a duration that the paths after contact do not have is not a number.
    """
    scale = states[:, -1, None]
    paths = scale[..., None, None] * states[:, :24].reshape(-1, 4, 2, 3)
    between = paths[:, 1] - paths[:, 0]
    touching = np.array(sum(radii))
    wait = _wait(between[:, 0], between[:, 1], touching)[:, None, None]
    velocity = paths[:, :, 1] + accelerations * wait
    place = paths[:, :, 0] + (paths[:, :, 1] + velocity) / 2 * wait
    normal = place[:, 1] - place[:, 0]
    normal /= np.sqrt((normal**2).sum(axis=-1, keepdims=True))
    spin = states[:, 24:36].reshape(-1, 4, 3)
    if unseen is not None:
        velocity[:, 2:, 2] = unseen.after(velocity, spin, normal)
        paths[:, 2:, 1, 2] = velocity[:, 2:, 2]
        paths[:, 2:, 0, 2] = place[:, :2, 2] - wait[:, 0] * velocity[:, 2:, 2]
    apart = paths[:, 3] - paths[:, 2]
    lasts = parting_time(apart[:, 0], apart[:, 1], touching)[:, None] - wait[:, 0]
    before = ContactState(velocity[:, 0], velocity[:, 1], spin[:, 0], spin[:, 1])
    after = ContactState(velocity[:, 2], velocity[:, 3], spin[:, 2], spin[:, 3])
    v = impact_velocities(before, after, normal, radii)
    scalars = np.stack([v.v_n, v.v_s, v.v_n_after, v.v_s_after, v.e, v.beta], axis=1)
    parts = [
        part for s in (before, after) for part in (s.velocity_a, s.velocity_b, s.spin_a, s.spin_b)
    ]
    return np.concatenate([reference + wait[:, 0], normal, scalars, *parts, lasts], axis=1)


def _seen_turned(centre: Floats) -> Floats:
    """Return what the states change by where a sphere's orientations are seen turned by 1 rad.

    About each axis of each sphere, shape (6, 37): turns of a in the first three rows.
    """
    turned = np.zeros((2, 3, len(centre)))
    spins = turned[..., 24:36].reshape(2, 3, 2, 2, 3)
    for sphere in (0, 1):
        own = centre[24:36].reshape(2, 2, 3)[:, sphere]
        spins[sphere, :, :, sphere] = np.cross(np.eye(3)[:, None], own)
    turned[..., 24:36] = spins.reshape(2, 3, 12)
    return turned.reshape(6, len(centre))


def _block_diagonal(blocks: list[Floats]) -> Floats:
    size = sum(len(block) for block in blocks)
    whole = np.zeros((size, size))
    start = 0
    for block in blocks:
        whole[start : start + len(block), start : start + len(block)] = block
        start += len(block)
    return whole


def _named(values: Floats, spread: Floats, shared: Floats, determined: NDArray[np.bool_]) -> Impact:
    """Name the outcomes.

    Parameters
    ----------
    values, spread
        Shapes (35,) and (35, 35).
    shared
        What one standard error of each shared thing does to them, shape (5, 35).
    determined
        Whether each spin is: of a and b before, of a and b after.
    """
    sigma = np.sqrt(np.clip(np.diag(spread), 0.0, None))
    common = np.sqrt((shared[:HELD] ** 2).sum(axis=0))
    state, state_sigma = (part[STATES].reshape(2, 4, 3).copy() for part in (values, sigma))
    for part in (state, state_sigma):
        part[:, 2:][~determined.reshape(2, 2)] = np.nan

    def quantity(i: int, unit: str) -> Quantity:
        return Quantity(float(values[i]), float(sigma[i]), unit, float(common[i]))

    surface = bool(determined.all())
    above_zero = surface and values[5] > BETA_NEEDS_SIGMAS * sigma[5]
    return Impact(
        contact_time=quantity(0, "s"),
        duration=quantity(34, "s") if np.isfinite(sigma[34]) else None,
        normal=values[1:4],
        normal_sigma=sigma[1:4],
        v_n=quantity(4, "m/s"),
        v_s=quantity(5, "m/s") if surface else None,
        v_n_after=quantity(6, "m/s"),
        v_s_after=quantity(7, "m/s") if surface else None,
        e=quantity(8, "1"),
        beta=quantity(9, "1") if above_zero else None,
        covariance=spread[VELOCITIES, VELOCITIES],
        shared=shared[:, VELOCITIES],
        before=ContactState(*state[0]),
        after=ContactState(*state[1]),
        state_sigma=state_sigma,
    )
