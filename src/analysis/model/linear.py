"""The comparison of prediction and data to first order: residuals and all derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.model.contact import AFTER, DURATION, SHIFT, TURN, differentiated_contact
from analysis.model.poses import PoseData
from analysis.model.prediction import (
    SIDES,
    Poses,
    Timing,
    linear_flight,
    linear_turning,
    predict,
    true_timing,
)
from analysis.model.state import MOTION, POINT, SIZE, TILT, TIME, TURN_A, TURN_B, ShotStates
from analysis.model.theory import Theory
from analysis.motion.rotation import rotation_matrix, rotation_vector

Floats = NDArray[np.float64]

_CAMERA_STEP = 1e-6
_OWN_TURN = (TURN_A, TURN_B)


@dataclass(frozen=True, slots=True, eq=False)
class Linearised:
    """Whitened residuals and derivatives of the prediction, N = 12 F numbers for each of S shots.

    Attributes
    ----------
    residual
        (observed - predicted) / sigma; orientations as rotation vectors of R_observed
        R_predicted'. Zero where nothing was measured. Shape (S, N).
    by_state
        Whitened derivatives of the prediction by the 24 numbers of the shot, shape (S, N, 24).
    by_theory
        The same by the parameters that all shots share, shape (S, N, P).
    """

    residual: Floats
    by_state: Floats
    by_theory: Floats


def linearise(data: PoseData, states: ShotStates, theory: Theory) -> Linearised:
    """Predict all poses and compare them with the data, to first order about states and theory."""
    poses = predict(data, states, theory)
    return Linearised(
        residual=whitened_residual(data, poses),
        by_state=_by_state(data, states, theory),
        by_theory=by_theory(data, states, theory, poses),
    )


def whitened_residual(data: PoseData, poses: Poses) -> Floats:
    """Return (observed - predicted) / sigma of every number, shape (S, N)."""
    turned = rotation_vector(data.rotation @ np.swapaxes(poses.rotation, -1, -2))
    return _flat(np.concatenate([data.position - poses.position, turned], axis=-1) * _weights(data))


def by_theory(data: PoseData, states: ShotStates, theory: Theory, poses: Poses) -> Floats:
    """Differentiate the prediction by every shared parameter, shape (S, N, P)."""
    vector, columns = theory.vector, []
    for k, step in enumerate(theory.steps):
        shifted = vector.copy()
        shifted[k] += step
        columns.append(difference(data, poses, predict(data, states, theory.at(shifted)), step))
    return np.stack(columns, axis=-1)


def difference(data: PoseData, poses: Poses, moved: Poses, step: float) -> Floats:
    """Return the whitened change of the prediction for a step, divided by it, shape (S, N)."""
    turned = rotation_vector(moved.rotation @ np.swapaxes(poses.rotation, -1, -2))
    change = np.concatenate([moved.position - poses.position, turned], axis=-1)
    return _flat(change * _weights(data)) / step


def _weights(data: PoseData) -> Floats:
    sigma = np.concatenate(
        [data.position_sigma, np.repeat(data.rotation_sigma[..., None], 3, axis=-1)], axis=-1
    )
    return np.where(np.isfinite(sigma), 1.0 / sigma, 0.0)


def _flat(numbers: Floats) -> Floats:
    return numbers.reshape(len(numbers), -1)


def _by_state(data: PoseData, states: ShotStates, theory: Theory) -> Floats:
    """Differentiate by the shots' own numbers, shape (S, N, 24).

    The little that forces in flight and the clock change with the state is left out.
    """
    contact = differentiated_contact(data, states, theory)
    timing = true_timing(data, states, theory, contact.outcome)
    parts = []
    for i in (0, 1):
        place = _place_derivatives(data, states, (contact.outcome, contact.by_state), timing, i)
        turn = _turn_derivatives(states, (contact.outcome, contact.by_state), timing, i)
        parts.append(np.concatenate([place, turn], axis=2))
    both = np.stack(parts, axis=2)
    if theory.camera:
        both[..., :3, :] = _camera_response(data, states, theory) @ both[..., :3, :]
    shots = len(states.time_s)
    return (both * _weights(data)[..., None]).reshape(shots, -1, SIZE)


def _camera_response(data: PoseData, states: ShotStates, theory: Theory) -> Floats:
    """Return the derivative of apparent by true position, shape (S, F, 2, 3, 3)."""
    true = predict(data, states, Theory(theory.law)).position

    def appear(position: Floats) -> Floats:
        for effect, values in theory.camera:
            position = effect.appear(position, data.camera, values)
        return position

    here = appear(true)
    columns = [(appear(true + _CAMERA_STEP * axis) - here) / _CAMERA_STEP for axis in np.eye(3)]
    return np.stack(columns, axis=-1)


def _place_derivatives(
    data: PoseData,
    states: ShotStates,
    contact: tuple[Floats, Floats],
    timing: Timing,
    i: int,
) -> Floats:
    """Differentiate the centre of one sphere, shape (S, F, 3, 24)."""
    outcome, by_state = contact
    tau = timing.position[:, :, i]
    velocity, _, since = linear_flight(data, states, outcome, tau, i)
    flown = (tau > 0)[..., None]
    own = slice(3 * i, 3 * i + 3)
    derivative = _outcome_derivatives(by_state[:, AFTER][:, own], i, flown) * since[..., None]
    leave = np.zeros((len(outcome), 3, SIZE))
    leave[:, :, TILT.start : MOTION.stop] = by_state[:, SHIFT][:, own]
    late = np.zeros((len(outcome), 1, SIZE))
    late[:, :, TILT.start : MOTION.stop] = by_state[:, DURATION]
    derivative += np.where(flown, leave[:, None], 0.0)
    derivative -= np.where(flown, late[:, None], 0.0) * velocity[..., None]
    gravity = np.array([data.gravity, 0.0, 0.0])
    derivative[..., TIME] = -(velocity + gravity * tau)[..., None]
    derivative[..., POINT] += np.eye(3)
    reach = SIDES[i] * data.bodies[i].radius
    derivative[..., TILT] += reach * np.stack(states.tangents(), axis=-1)[:, None]
    return derivative


def _turn_derivatives(
    states: ShotStates, contact: tuple[Floats, Floats], timing: Timing, i: int
) -> Floats:
    """Differentiate the orientation of one sphere as a rotation vector, shape (S, F, 3, 24)."""
    outcome, by_state = contact
    tau = timing.rotation[:, :, i]
    spin, _, since = linear_turning(states, outcome, tau, i)
    flown = (tau > 0)[..., None, None]
    own = slice(3 * i, 3 * i + 3)
    angle = spin * since[..., None]
    response = since[..., None, None] * left_jacobian(angle)
    after = by_state[:, AFTER][:, 6 + 3 * i : 9 + 3 * i]
    derivative = response @ _outcome_derivatives(after, 2 + i, flown)
    turned = rotation_matrix(angle)
    leave = np.zeros((len(outcome), 3, SIZE))
    leave[:, :, TILT.start : MOTION.stop] = by_state[:, TURN][:, own]
    late = np.zeros((len(outcome), 1, SIZE))
    late[:, :, TILT.start : MOTION.stop] = by_state[:, DURATION]
    derivative += np.where(flown, turned @ leave[:, None], 0.0)
    derivative -= np.where(flown, late[:, None], 0.0) * spin[..., None]
    derivative[..., TIME] = -spin[..., None]
    meanwhile = rotation_matrix(outcome[:, TURN][:, own])
    start = np.where(flown, meanwhile[:, None], np.eye(3))
    derivative[..., _OWN_TURN[i]] = turned @ start
    return derivative


def _outcome_derivatives(after: Floats, row: int, flown: NDArray[np.bool_]) -> Floats:
    """Return the derivative of a frame's velocity or spin by the state, shape (S, F, 3, 24).

    Before contact it is one of the state's own numbers, after it what the operator makes of all.
    """
    before, beyond = np.zeros((len(after), 3, SIZE)), np.zeros((len(after), 3, SIZE))
    before[:, :, MOTION.start + 3 * row : MOTION.start + 3 * row + 3] = np.eye(3)
    beyond[:, :, TILT.start : MOTION.stop] = after
    return np.where(flown, beyond[:, None], before[:, None])


def left_jacobian(vector: Floats) -> Floats:
    """Return d log(exp(v + dv) exp(-v)) / dv, the left Jacobian, (..., 3) to (..., 3, 3).

    G. S. Chirikjian, Stochastic Models, Information Theory, and Lie Groups 2 (2012), section 10.8.
    """
    angle = np.linalg.norm(vector, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack(
        [np.stack([zero, -z, y], -1), np.stack([z, zero, -x], -1), np.stack([-y, x, zero], -1)], -2
    )
    safe = np.maximum(angle, 1e-4)
    third = np.where(angle > 1e-4, (safe - np.sin(safe)) / safe**3, 1 / 6)
    half = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    return np.asarray(np.eye(3) + half * cross + third * (cross @ cross))
