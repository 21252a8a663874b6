"""The contact of every shot, with its derivatives by the state before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Encounter, Operator, Outcome, States, inverse_masses
from analysis.model.data.poses import Observations, PoseData
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

AFTER, DURATION, SHIFT, TURN = slice(0, 12), slice(12, 13), slice(13, 19), slice(19, 25)
"""Where the numbers of an outcome stand in a row: velocities and spins after, time to separation,
shifts of both centres, turns of both spheres."""

_TILT_STEP, _SPEED_STEP, _SPIN_STEP = 1e-6, 1e-5, 1e-3
_STEPS = np.array([_TILT_STEP] * 2 + [_SPEED_STEP] * 6 + [_SPIN_STEP] * 6)
_VELOCITY_A, _FIRST_SPIN = slice(2, 5), 8
"""Where the velocity of a stands among these, and where spins begin."""


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Outcomes and their derivatives.

    Attributes
    ----------
    outcome
        Shape (S, 25).
    by_state
        Derivatives by tilt, velocities and spins, shape (S, 25, 14).
    about
        The outcome that differences are taken from: as many steps of integration on both sides.
    """

    outcome: Floats
    by_state: Floats
    about: Floats


def _kicked(data: Observations, states: ShotStates, outcome: Floats, normal: Floats) -> Floats:
    """Add to outcomes (S, 25) what kicks across a normal do, momentum and its moment kept."""
    kick = states.kick
    if kick is None:
        return outcome
    response = _by_kick(data, normal, kick.unknown)
    return outcome + (response @ kick.change[..., None])[..., 0]


def _by_kick(data: Observations, normal: Floats, unknown: NDArray[np.bool_]) -> Floats:
    """Differentiate outcomes by a change of the relative velocity, shape (S, 25, 3).

    A spin that nobody measured stays where it is held.
    """
    a, b = data.bodies
    across = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    impulse = across / inverse_masses(data.bodies)[0]
    twist = np.cross(normal[:, None, :], np.swapaxes(impulse, 1, 2))
    twist = np.swapaxes(twist, 1, 2)
    known = ~unknown[:, :, None, None]
    change = np.zeros((len(normal), TURN.stop, 3))
    change[:, 0:3], change[:, 3:6] = -impulse / a.mass, impulse / b.mass
    change[:, 6:9] = -a.radius / a.inertia * twist * known[:, 0]
    change[:, 9:12] = -b.radius / b.inertia * twist * known[:, 1]
    return change


def contact_outcome(data: Observations, states: ShotStates, theory: Theory) -> Floats:
    """Return the outcome of every contact, shape (S, 25)."""
    return _outcome(data, states, theory, theory.operator)


def outcome_of_slopes(data: Observations, states: ShotStates, theory: Theory) -> Floats:
    """Return the outcome of every contact for a difference from `Contact.about`, (S, 25)."""
    return _outcome(data, states, theory, theory.operator_of_slopes)


def _outcome(data: Observations, states: ShotStates, theory: Theory, operator: Operator) -> Floats:
    encounter = _encounter(data, theory, states, _motion(states), states.normal)
    outcome = _row(data, operator(encounter))
    return _kicked(data, states, outcome, theory.leaning(states.normal))


def differentiated_contact(data: Observations, states: ShotStates, theory: Theory) -> Contact:
    """Differentiate the operator by forward differences, all of them in one call of it.

    A law that is integrated depends on the relative velocity alone: by the velocity of a it is
    differentiated as by that of b.
    """
    lasts = theory.contact_law is not None
    shots, spared = len(states.time_s), 3 if lasts else 0
    motions = np.repeat(_motion(states)[None], 15 - spared, axis=0)
    normals = np.repeat(states.normal[None], 15 - spared, axis=0)
    for k, tangent in enumerate(states.tangents()):
        tilted = states.normal + _TILT_STEP * tangent
        normals[1 + k] = tilted / np.linalg.norm(tilted, axis=1, keepdims=True)
    for k in range(spared, 12):
        motions[3 + k - spared, :, k] += _STEPS[2 + k]
    encounter = _encounter(data, theory, states, motions.reshape(-1, 12), normals.reshape(-1, 3))
    outcomes = _row(data, theory.operator_of_slopes(encounter))
    outcomes = outcomes.reshape(15 - spared, shots, -1)
    unkicked = outcomes[0].copy()
    for k in range(3):
        outcomes[k] = _kicked(data, states, outcomes[k], theory.leaning(normals[k]))
    # A kick is across the normal: velocities and spins change nothing of it, a tilt does.
    outcomes[3:] += outcomes[0] - unkicked
    steps = np.delete(_STEPS, _VELOCITY_A) if lasts else _STEPS
    by_state = (outcomes[1:] - outcomes[0]) / steps[:, None, None]
    if lasts:
        by_first = _by_common_velocity(outcomes[0]) - by_state[_VELOCITY_A]
        by_state = np.concatenate([by_state[: _VELOCITY_A.start], by_first, by_state[2:]])
    derivative = np.moveaxis(by_state, 0, 2)
    if states.kick is not None:
        rows, unknown = states.kick.shots, states.kick.unknown
        normal = states.normal[rows]
        # Of a step's kick only what lies across the normal is taken (`Kick.taken`).
        taken = np.eye(3) - normal[:, :, None] * normal[:, None, :]
        kicks = _by_kick(data, theory.leaning(normal), unknown[rows]) @ taken
        for k in range(3):
            derivative[rows, :, _FIRST_SPIN + 3 * states.kick.sphere + k] = kicks[..., k]
    # Without a law that is integrated both are the same.
    about = outcomes[0]
    return Contact(contact_outcome(data, states, theory) if lasts else about, derivative, about)


def _by_common_velocity(outcome: Floats) -> Floats:
    """Differentiate outcomes (S, 25) by a velocity that both bodies have, shape (3, S, 25)."""
    change = np.zeros((3, *outcome.shape))
    for axis in range(3):
        change[axis, :, [axis, 3 + axis]] = 1.0
        for shift in (SHIFT.start + axis, SHIFT.start + 3 + axis):
            change[axis, :, shift] = outcome[:, DURATION.start]
    return change


def encounter_of(data: Observations, states: ShotStates, theory: Theory) -> Encounter:
    """Return how the spheres of every shot meet, as effects of the contact are given it."""
    return _encounter(data, theory, states, _motion(states), states.normal)


def _encounter(
    data: Observations, theory: Theory, states: ShotStates, motion: Floats, normal: Floats
) -> Encounter:
    """Return encounters of rows of motion (N, 12) and normals (N, 3), a multiple of the shots.

    Where they touch and how they are turned is that of their shot, whatever moves in the row. A
    shot whose spins are not known slips without friction; its kick is the friction's impulse.
    """
    repeats = len(motion) // len(data.shots)
    law, parts = theory.law, motion.reshape(-1, 4, 3)
    friction = np.full(len(data.shots), law.mu)
    if states.kick is not None:
        friction[states.kick.shots] = 0.0
    return Encounter(
        before=States(*(parts[:, k] for k in range(4))),
        normal=normal,
        bodies=data.bodies,
        e=np.full(len(motion), law.e),
        mu=_repeated(friction, repeats),
        beta0=np.full(len(motion), law.beta0),
        covariates={name: _repeated(own, repeats) for name, own in data.covariates.items()},
        gravity=data.gravity if isinstance(data, PoseData) and data.on_plate else 0.0,
        point=_repeated(states.point, repeats) if isinstance(data, PoseData) else None,
        rotation=_repeated(states.rotation, repeats) if isinstance(data, PoseData) else None,
    )


def _repeated(numbers: Floats, repeats: int) -> Floats:
    return numbers if repeats == 1 else np.tile(numbers, (repeats, *[1] * (numbers.ndim - 1)))


def _row(data: Observations, outcome: Outcome) -> Floats:
    """Return the numbers of outcomes, shape (N, 25).

    A flight falls from first touch on. What a plate has held up meanwhile is told from there.
    """
    after, held = outcome.after, outcome.after.velocity_a
    if isinstance(data, PoseData) and data.on_plate:
        held = held - np.outer(outcome.duration, (data.gravity, 0.0, 0.0))
    return np.concatenate(
        [
            held,
            after.velocity_b,
            after.spin_a,
            after.spin_b,
            outcome.duration[:, None],
            outcome.shift_a,
            outcome.shift_b,
            outcome.turn_a,
            outcome.turn_b,
        ],
        axis=1,
    )


def _motion(states: ShotStates) -> Floats:
    before = states.before
    parts = [before.velocity_a, before.velocity_b, before.spin_a, before.spin_b]
    return np.concatenate(parts, axis=1)
