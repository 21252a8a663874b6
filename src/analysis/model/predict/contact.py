"""The contact of every shot, with its derivatives by the state before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Encounter, Outcome, States, gives
from analysis.model.data.poses import Observations, PoseData
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

Floats = NDArray[np.float64]

AFTER, DURATION, SHIFT, TURN = slice(0, 12), slice(12, 13), slice(13, 19), slice(19, 25)
"""Where the numbers of an outcome stand in a row: velocities and spins after, time to separation,
shifts of both centres, turns of both spheres."""

_TILT_STEP, _SPEED_STEP, _SPIN_STEP = 1e-6, 1e-5, 1e-3
_STEPS = np.array([_TILT_STEP] * 2 + [_SPEED_STEP] * 6 + [_SPIN_STEP] * 6)
_FIRST_SPIN = 8
"""Where spins begin among these."""


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Outcomes, shape (S, 25), and derivatives by tilt, velocities and spins, shape (S, 25, 14)."""

    outcome: Floats
    by_state: Floats


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
    impulse = across / gives(data.bodies)[0]
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
    outcome = _outcomes(data, theory, states, _motion(states), states.normal)
    return _kicked(data, states, outcome, states.normal)


def differentiated_contact(data: Observations, states: ShotStates, theory: Theory) -> Contact:
    """Differentiate the operator by forward differences, all of them in one call of it."""
    shots = len(states.time_s)
    motions = np.repeat(_motion(states)[None], 15, axis=0)
    normals = np.repeat(states.normal[None], 15, axis=0)
    for k, tangent in enumerate(states.tangents()):
        tilted = states.normal + _TILT_STEP * tangent
        normals[1 + k] = tilted / np.linalg.norm(tilted, axis=1, keepdims=True)
    for k in range(12):
        motions[3 + k, :, k] += _STEPS[2 + k]
    outcomes = _outcomes(data, theory, states, motions.reshape(-1, 12), normals.reshape(-1, 3))
    outcomes = outcomes.reshape(15, shots, -1)
    unkicked = outcomes[0].copy()
    for k in range(3):
        outcomes[k] = _kicked(data, states, outcomes[k], normals[k])
    # A kick is across the normal: velocities and spins change nothing of it, a tilt does.
    outcomes[3:] += outcomes[0] - unkicked
    by_state = (outcomes[1:] - outcomes[0]) / _STEPS[:, None, None]
    derivative = np.moveaxis(by_state, 0, 2)
    if states.kick is not None:
        rows, unknown = states.kick.shots, states.kick.unknown
        kicks = _by_kick(data, states.normal[rows], unknown[rows])
        for k in range(3):
            derivative[rows, :, _FIRST_SPIN + 3 * states.kick.sphere + k] = kicks[..., k]
    return Contact(outcomes[0], derivative)


def encounter_of(data: Observations, states: ShotStates, theory: Theory) -> Encounter:
    """Return how the spheres of every shot meet, as effects of the contact are given it."""
    return _encounter(data, theory, states, _motion(states), states.normal)


def _outcomes(
    data: Observations, theory: Theory, states: ShotStates, motion: Floats, normal: Floats
) -> Floats:
    """Return outcomes for rows of motion (N, 12) and normals (N, 3); N a multiple of the shots."""
    return _row(theory.operator(_encounter(data, theory, states, motion, normal)))


def _encounter(
    data: Observations, theory: Theory, states: ShotStates, motion: Floats, normal: Floats
) -> Encounter:
    """Return encounters of rows of motion (N, 12) and normals (N, 3).

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
        point=_repeated(states.point, repeats) if isinstance(data, PoseData) else None,
        rotation=_repeated(states.rotation, repeats) if isinstance(data, PoseData) else None,
    )


def _repeated(numbers: Floats, repeats: int) -> Floats:
    return numbers if repeats == 1 else np.tile(numbers, (repeats, *[1] * (numbers.ndim - 1)))


def _row(outcome: Outcome) -> Floats:
    after = outcome.after
    return np.concatenate(
        [
            after.velocity_a,
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
