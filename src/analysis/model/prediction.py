"""Poses as the theory predicts them from the state of each shot.

    state --contact--> state after --flight--> positions and orientations at the frames' true
    times --camera--> where the images show them

Both sides of the contact share its point, instant and orientations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.effects.effect import Exposure, Flying
from analysis.model.contact import AFTER, DURATION, SHIFT, TURN, contact_outcome
from analysis.model.poses import PoseData
from analysis.model.state import ShotStates
from analysis.model.theory import Theory
from analysis.motion.rotation import rotation_matrix

Floats = NDArray[np.float64]

SIDES = (-1.0, 1.0)
"""Centre of a and of b along the normal from the point of contact, in radii."""
_NODES = np.array([0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12)])
"""Gauss-Legendre nodes on (0, 1); both weigh a half."""


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Predicted positions (S, F, 2, 3), m, and orientations (S, F, 2, 3, 3), body to rig axes."""

    position: Floats
    rotation: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Timing:
    """True times since first touch, s, by sphere.

    Attributes
    ----------
    position
        Of each coordinate, as the two views may show a sphere at two times, shape (S, F, 2, 3).
    rotation
        Of the orientation, shape (S, F, 2).
    """

    position: Floats
    rotation: Floats


def predict(data: PoseData, states: ShotStates, theory: Theory) -> Poses:
    """Predict the pose of both spheres in every frame."""
    outcome = contact_outcome(data, states, theory)
    timing = true_timing(data, states, theory, outcome)
    flights = [fly(data, states, outcome, timing, theory=theory, sphere=i) for i in (0, 1)]
    position = np.stack([place for place, _ in flights], axis=2)
    for effect, values in theory.camera:
        position = effect.appear(position, data.camera, values)
    return Poses(position, np.stack([turned for _, turned in flights], axis=2))


def true_timing(data: PoseData, states: ShotStates, theory: Theory, outcome: Floats) -> Timing:
    """Return when the frames were really exposed, counted from first touch."""
    stated = data.times_s - states.time_s[:, None]
    start = Timing(np.tile(stated[..., None, None], (2, 3)), np.tile(stated[..., None], 2))
    timing, bare = start, Theory(theory.law)
    # A time that hangs on the place hangs on it at that time: the second pass knows where.
    for _ in range(2 if theory.clock else 0):
        places = [fly(data, states, outcome, timing, theory=bare, sphere=i)[0] for i in (0, 1)]
        exposure = Exposure(data.times_s, np.stack(places, axis=2))
        position, rotation = start.position, start.rotation
        for effect, values in theory.clock:
            seen, turned = effect.expose(exposure, data.camera, values)
            position = position + (seen - data.times_s[..., None, None])
            rotation = rotation + (turned - data.times_s[..., None])
        timing = Timing(position, rotation)
    return timing


def fly(
    data: PoseData,
    states: ShotStates,
    outcome: Floats,
    timing: Timing,
    *,
    theory: Theory,
    sphere: int,
) -> tuple[Floats, Floats]:
    """Return positions (S, F, 3) and orientations (S, F, 3, 3) of a sphere before the camera."""
    tau = timing.position[:, :, sphere]
    velocity, start, since = linear_flight(data, states, outcome, tau, sphere)
    gravity = np.array([data.gravity, 0.0, 0.0])
    position = start + velocity * since + 0.5 * gravity * tau**2
    tau_turn = timing.rotation[:, :, sphere]
    spin, turned, since_turn = linear_turning(states, outcome, tau_turn, sphere)
    rotation = rotation_matrix(spin * since_turn[..., None]) @ turned
    if theory.flight:
        push, twist = _perturbation(
            data, theory, (position, velocity, spin), (since, since_turn), sphere
        )
        position = position + push
        rotation = rotation_matrix(twist) @ rotation
    return position, rotation


def linear_flight(
    data: PoseData, states: ShotStates, outcome: Floats, tau: Floats, i: int
) -> tuple[Floats, Floats, Floats]:
    """Return velocity and starting point of a frame's side, and the time from there, (S, F, 3).

    `tau` is the time from first touch of each coordinate, shape (S, F, 3).
    """
    flown = tau > 0
    before = (states.before.velocity_a, states.before.velocity_b)[i]
    after = outcome[:, AFTER][:, 3 * i : 3 * i + 3]
    touch = states.point + SIDES[i] * data.bodies[i].radius * states.normal
    leave = touch + outcome[:, SHIFT][:, 3 * i : 3 * i + 3]
    since = tau - np.where(flown, outcome[:, DURATION, None], 0.0)
    return _sides(before, after, flown), _sides(touch, leave, flown), since


def linear_turning(
    states: ShotStates, outcome: Floats, tau: Floats, i: int
) -> tuple[Floats, Floats, Floats]:
    """Return spin (S, F, 3) and starting orientation of a frame's side, and the time from there."""
    flown = tau > 0
    before = (states.before.spin_a, states.before.spin_b)[i]
    after = outcome[:, AFTER][:, 6 + 3 * i : 9 + 3 * i]
    touch = states.rotation[:, i]
    leave = rotation_matrix(outcome[:, TURN][:, 3 * i : 3 * i + 3]) @ touch
    since = tau - np.where(flown, outcome[:, DURATION], 0.0)
    start = np.where(flown[..., None, None], leave[:, None], touch[:, None])
    return _sides(before, after, flown[..., None]), start, since


def _sides(before: Floats, after: Floats, flown: NDArray[np.bool_]) -> Floats:
    return np.where(flown, after[:, None], before[:, None])


def _perturbation(
    data: PoseData,
    theory: Theory,
    motion: tuple[Floats, Floats, Floats],
    since: tuple[Floats, Floats],
    i: int,
) -> tuple[Floats, Floats]:
    """Return what small forces add: displacement and rotation vector, shape (S, F, 3).

    Double integrals of the acceleration along the unperturbed path, int_0^t (t - s) a(s) ds.
    """
    position, velocity, spin = motion
    flown, turned = since[0], since[1][..., None]
    gravity = np.array([data.gravity, 0.0, 0.0])
    push, twist = np.zeros_like(position), np.zeros_like(position)
    for node in _NODES:
        back = (1.0 - node) * flown
        flying = Flying(
            position=position - velocity * back,
            velocity=velocity + gravity * node * flown,
            spin=spin,
            body=data.bodies[i],
            gravity=data.gravity,
            air_density=data.air_density,
        )
        for effect, values in theory.flight:
            linear, angular = effect.accelerate(flying, values)
            push += 0.5 * flown * back * linear
            twist += 0.5 * (1.0 - node) * turned**2 * angular
    return push, twist
