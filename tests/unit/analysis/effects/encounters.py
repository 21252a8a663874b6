"""Encounters to try an effect on, and what must hold whatever the effect."""

from __future__ import annotations

import numpy as np

from analysis.collision.operator import Body, Encounter, Outcome, States, walton
from analysis.effects.effect import ContactEffect

NYLON = Body.sphere(0.0254, 1150.0, 0.4)
X, Y, Z = np.eye(3)


def head_on(
    approach: float | list[float],
    sliding: float | list[float] = 0.0,
    spin_about_normal: float = 0.0,
    law: tuple[float, float, float] = (0.74, 0.08, 0.5),
) -> Encounter:
    """Return encounters along Y: b comes with v_n against a and passes it along X with v_t.

    Half the relative spin about the normal is on each sphere; `order` runs from -0.5 to 0.5.
    """
    v_n, v_t = np.broadcast_arrays(np.atleast_1d(approach), np.atleast_1d(sliding))
    shots = len(v_n)
    relative = -v_n[:, None] * Y + v_t[:, None] * X
    spin = np.tile(spin_about_normal / 2 * Y, (shots, 1))
    e, mu, beta0 = (np.full(shots, value) for value in law)
    return Encounter(
        before=States(-relative / 2, relative / 2, -spin, spin),
        normal=np.tile(Y, (shots, 1)),
        bodies=(NYLON, NYLON),
        e=e,
        mu=mu,
        beta0=beta0,
        covariates={"order": np.linspace(-0.5, 0.5, shots)},
    )


def any_encounters(
    shots: int = 300, seed: int = 0, law: tuple[float, float, float] = (0.74, 0.08, 0.5)
) -> Encounter:
    """Return encounters in every direction, at 0.2 to 4 m/s and up to 100 rad/s."""
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=(shots, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    velocity = rng.normal(0.0, 1.0, (shots, 2, 3))
    closing = rng.uniform(0.2, 4.0, shots)
    relative = velocity[:, 1] - velocity[:, 0]
    along = (relative * normal).sum(axis=1)
    velocity[:, 1] -= (along + closing)[:, None] * normal
    spin = rng.normal(0.0, 40.0, (shots, 2, 3))
    e, mu, beta0 = (np.full(shots, value) for value in law)
    return Encounter(
        before=States(velocity[:, 0], velocity[:, 1], spin[:, 0], spin[:, 1]),
        normal=normal,
        bodies=(NYLON, NYLON),
        e=e,
        mu=mu,
        beta0=beta0,
        covariates={"order": rng.uniform(-0.5, 0.5, shots)},
    )


def after(effect: ContactEffect, values: float | list[float], encounter: Encounter) -> Outcome:
    return effect.wrap(walton, np.atleast_1d(np.array(values, dtype=float)))(encounter)


def separation(encounter: Encounter, outcome: Outcome) -> np.ndarray:
    """Return v_n', m/s."""
    relative = outcome.after.velocity_b - outcome.after.velocity_a
    return (relative * encounter.normal).sum(axis=1)


def surface(state: States, normal: np.ndarray, radius: float = NYLON.radius) -> np.ndarray:
    """Return the relative surface velocity across the normal, written out for equal spheres."""
    relative = state.velocity_b - state.velocity_a
    relative = relative - (relative * normal).sum(axis=1, keepdims=True) * normal
    return relative + radius * np.cross(normal, state.spin_a + state.spin_b)


def momentum(state: States, bodies: tuple[Body, Body]) -> np.ndarray:
    return bodies[0].mass * state.velocity_a + bodies[1].mass * state.velocity_b


def energy(state: States, bodies: tuple[Body, Body]) -> np.ndarray:
    pairs = ((state.velocity_a, state.spin_a), (state.velocity_b, state.spin_b))
    return sum(
        body.mass / 2 * (v**2).sum(axis=1) + body.inertia / 2 * (w**2).sum(axis=1)
        for body, (v, w) in zip(bodies, pairs, strict=True)
    )
