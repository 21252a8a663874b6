"""The contact of every shot, with its derivatives by the state before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Encounter, Outcome, States
from analysis.model.poses import Observations
from analysis.model.state import ShotStates
from analysis.model.theory import Theory

Floats = NDArray[np.float64]

AFTER, DURATION, SHIFT, TURN = slice(0, 12), slice(12, 13), slice(13, 19), slice(19, 25)
"""Where the numbers of an outcome stand in a row: velocities and spins after, time to separation,
shifts of both centres, turns of both spheres."""

_TILT_STEP, _SPEED_STEP, _SPIN_STEP = 1e-6, 1e-5, 1e-3
_STEPS = np.array([_TILT_STEP] * 2 + [_SPEED_STEP] * 6 + [_SPIN_STEP] * 6)


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Outcomes, shape (S, 25), and derivatives by tilt, velocities and spins, shape (S, 25, 14)."""

    outcome: Floats
    by_state: Floats


def contact_outcome(data: Observations, states: ShotStates, theory: Theory) -> Floats:
    """Return the outcome of every contact, shape (S, 25)."""
    return _outcomes(data, theory, _motion(states), states.normal)


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
    outcomes = _outcomes(data, theory, motions.reshape(-1, 12), normals.reshape(-1, 3))
    outcomes = outcomes.reshape(15, shots, -1)
    by_state = (outcomes[1:] - outcomes[0]) / _STEPS[:, None, None]
    return Contact(outcomes[0], np.moveaxis(by_state, 0, 2))


def _outcomes(data: Observations, theory: Theory, motion: Floats, normal: Floats) -> Floats:
    """Return outcomes for rows of motion (N, 12) and normals (N, 3); N a multiple of the shots."""
    repeats = len(motion) // len(data.shots)
    law, parts = theory.law, motion.reshape(-1, 4, 3)
    encounter = Encounter(
        before=States(*(parts[:, k] for k in range(4))),
        normal=normal,
        bodies=data.bodies,
        e=np.full(len(motion), law.e),
        mu=np.full(len(motion), law.mu),
        beta0=np.full(len(motion), law.beta0),
        covariates={name: np.tile(value, repeats) for name, value in data.covariates.items()},
    )
    return _row(theory.operator(encounter))


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
