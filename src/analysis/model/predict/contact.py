"""The contact of every shot, with its derivatives by the state before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Encounter, Operator, Outcome, States, inverse_masses
from analysis.effects.effect import ContactEffect
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
    """Differentiate the outcome of every contact by tilt, velocities and spins."""
    slopes_of = _by_symmetry if _turns_with_all(data, theory) else _by_differences
    outcome, by_tilt, by_motion = slopes_of(data, states, theory)
    about = _kicked(data, states, outcome, theory.leaning(states.normal))
    derivative = np.moveaxis(np.concatenate([by_tilt, by_motion]), 0, 2)
    if states.kick is not None:
        # A kick is across the normal: velocities and spins change nothing of it, a tilt does.
        for k, normal in enumerate(_tilted(states)):
            leaning = theory.leaning(normal)
            derivative[..., k] += (_kicked(data, states, outcome, leaning) - about) / _TILT_STEP
        rows, unknown = states.kick.shots, states.kick.unknown
        normal = states.normal[rows]
        # Of a step's kick only what lies across the normal is taken (`Kick.taken`).
        taken = np.eye(3) - normal[:, :, None] * normal[:, None, :]
        kicks = _by_kick(data, theory.leaning(normal), unknown[rows]) @ taken
        for k in range(3):
            derivative[rows, :, _FIRST_SPIN + 3 * states.kick.sphere + k] = kicks[..., k]
    # Without a law that is integrated both are the same.
    lasts = theory.contact_law is not None
    return Contact(contact_outcome(data, states, theory) if lasts else about, derivative, about)


def _tilted(states: ShotStates) -> list[Floats]:
    """Return normals a step along either tangent, shape (S, 3)."""
    moved = (states.normal + _TILT_STEP * tangent for tangent in states.tangents())
    return [normal / np.linalg.norm(normal, axis=1, keepdims=True) for normal in moved]


Slopes = tuple[Floats, Floats, Floats]
"""Outcomes, shape (S, 25), and their derivatives by two tilts, (2, S, 25), and by the velocities
and spins of a and b, (12, S, 25); kicks are in none of them."""


def _by_differences(data: Observations, states: ShotStates, theory: Theory) -> Slopes:
    """Differentiate by forward differences, all of them in one call of the operator.

    A law that is integrated depends on the relative velocity alone: by the velocity of a it is
    differentiated as by that of b.
    """
    lasts = theory.contact_law is not None
    shots, spared = len(states.time_s), 3 if lasts else 0
    motions = np.repeat(_motion(states)[None], 15 - spared, axis=0)
    normals = np.repeat(states.normal[None], 15 - spared, axis=0)
    normals[1:3] = _tilted(states)
    for k in range(spared, 12):
        motions[3 + k - spared, :, k] += _STEPS[2 + k]
    outcomes = _outcomes(data, states, theory, motions, normals).reshape(15 - spared, shots, -1)
    steps = np.delete(_STEPS, _VELOCITY_A) if lasts else _STEPS
    changes = (outcomes[1:] - outcomes[0]) / steps[:, None, None]
    by_motion = changes[2:]
    if lasts:
        by_first = _by_common_velocity(outcomes[0]) - by_motion[:3]
        by_motion = np.concatenate([by_first, by_motion])
    return outcomes[0], changes[:2], by_motion


def _turns_with_all(data: Observations, theory: Theory) -> bool:
    """Whether a contact that lasts depends on nothing but how both spheres meet.

    Then its outcome turns with all that goes in. Beside a plate gravity has a direction, and an
    effect of the contact may ask for one, or for the spin of one sphere.
    """
    if theory.contact_law is None or data.bodies[1].is_plate:
        return False
    return not any(isinstance(active.effect, ContactEffect) for active in theory.parts)


def _by_symmetry(data: Observations, states: ShotStates, theory: Theory) -> Slopes:
    """Differentiate by the relative velocity and the spin of a, and derive the others from these.

    The spheres' surfaces slip by r_a w_a + r_b w_b together: but for its own spin, b's does what
    a's does times r_b / r_a. (Levers are shorter by the overlap, a thousandth, which is neglected:
    slopes need not be better.) A tilt of the normal is a turn of everything, and all that moves
    turned back.
    """
    shots, motion = len(states.time_s), _motion(states)
    motions = np.repeat(motion[None], 7, axis=0)
    for k in range(6):
        motions[1 + k, :, 3 + k] += _STEPS[_VELOCITY_A.stop + k]
    normals = np.repeat(states.normal[None], 7, axis=0)
    outcomes = _outcomes(data, states, theory, motions, normals).reshape(7, shots, -1)
    steps = _STEPS[_VELOCITY_A.stop :][:6, None, None]
    here, changes = outcomes[0], (outcomes[1:] - outcomes[0]) / steps
    by_second, by_spin = changes[:3], changes[3:]
    kept_a, kept_b = (_by_kept_spin(here, sphere) for sphere in (0, 1))
    a, b = data.bodies
    by_other = b.radius / a.radius * (by_spin - kept_a) + kept_b
    by_first = _by_common_velocity(here) - by_second
    by_motion = np.concatenate([by_first, by_second, by_spin, by_other])
    turns = [np.cross(states.normal, tangent) for tangent in states.tangents()]
    by_tilt = [
        _turned(here, turn) - np.einsum("sk,ksn->sn", _turned(motion, turn), by_motion)
        for turn in turns
    ]
    return here, np.array(by_tilt), by_motion


def _outcomes(
    data: Observations, states: ShotStates, theory: Theory, motions: Floats, normals: Floats
) -> Floats:
    """Return outcomes of motions (N, S, 12) and normals (N, S, 3), shape (N S, 25)."""
    encounter = _encounter(data, theory, states, motions.reshape(-1, 12), normals.reshape(-1, 3))
    return _row(data, theory.operator_of_slopes(encounter))


def _turned(numbers: Floats, turn: Floats) -> Floats:
    """Return the change of vectors (S, 12) or outcomes (S, 25) for a unit of a turn (S, 3)."""
    vectors, duration = numbers[:, AFTER], np.zeros((len(numbers), 1))
    later = numbers[:, DURATION.stop :]
    both = np.concatenate([vectors, later], axis=1).reshape(len(numbers), -1, 3)
    turned = np.cross(turn[:, None], both).reshape(len(numbers), -1)
    if numbers.shape[1] == AFTER.stop:
        return turned
    return np.concatenate([turned[:, AFTER], duration, turned[:, AFTER.stop :]], axis=1)


def _by_kept_spin(outcome: Floats, sphere: int) -> Floats:
    """Differentiate outcomes (S, 25) by a spin that no contact changes, shape (3, S, 25)."""
    change = np.zeros((3, *outcome.shape))
    for axis in range(3):
        change[axis, :, 6 + 3 * sphere + axis] = 1.0
        change[axis, :, TURN.start + 3 * sphere + axis] = outcome[:, DURATION.start]
    return change


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
