"""Slots beside the coefficients: the torque about the normal, and impulses of their own.

An impulse along the normal that changes alone leaves friction where it was, and one across it
changes in contacts that stick and in those that slide. Both spheres share each impulse and torque,
so that momentum is kept.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import (
    Encounter,
    Outcome,
    inverse_masses,
    surface_velocity,
    with_impulse,
)

TORSION = "torsion"
IMPULSE_N, IMPULSE_T = "impulse_n", "impulse_t"
IMPULSES = (IMPULSE_N, IMPULSE_T)
_TORSION = 3 * np.pi / 16
"""K. L. Johnson, Contact Mechanics (1985), section 3.9: the torque of full slip on a Hertzian
contact is 3 pi mu a F / 16."""


def changed_outcome(slot: str, outcome: Outcome, encounter: Encounter, change: Floats) -> Outcome:
    """Return an outcome with one of these slots changed.

    Parameters
    ----------
    change
        Of torsion the radius of contact, m; of an impulse its relative change; shape (S,).
    """
    if slot == TORSION:
        return _twisted(outcome, encounter, change)
    impulse = _along(outcome, encounter) if slot == IMPULSE_N else _across(outcome, encounter)
    more = with_impulse(
        outcome.after, encounter.normal, encounter.bodies, change[:, None] * impulse
    )
    return replace(outcome, after=more)


def _along(outcome: Outcome, encounter: Encounter) -> Floats:
    """Return the impulse on b along the normal, kg m/s, shape (S, 3)."""
    before, after, normal = encounter.before, outcome.after, encounter.normal
    gained = after.velocity_b - after.velocity_a - before.velocity_b + before.velocity_a
    size = (gained * normal).sum(axis=1) / inverse_masses(encounter.bodies)[0]
    return np.asarray(size[:, None] * normal)


def _across(outcome: Outcome, encounter: Encounter) -> Floats:
    """Return the impulse on b across the normal, kg m/s, shape (S, 3)."""
    slip = surface_velocity(outcome.after, encounter.normal, encounter.bodies)
    return np.asarray((slip - encounter.sliding) / inverse_masses(encounter.bodies)[1])


def _twisted(outcome: Outcome, encounter: Encounter, radius: Floats) -> Outcome:
    """Return an outcome with a torque about the normal, against the relative spin there."""
    a, b = encounter.bodies
    before, after, normal = encounter.before, outcome.after, encounter.normal
    push = (
        (1 + encounter.e) * encounter.approach.clip(min=0.0) / inverse_masses(encounter.bodies)[0]
    )
    relative = ((before.spin_b - before.spin_a) * normal).sum(axis=1)
    twist = (_TORSION * encounter.mu * radius * push * np.sign(relative))[:, None] * normal
    return replace(
        outcome,
        after=replace(
            after,
            spin_a=after.spin_a + twist / a.inertia,
            spin_b=after.spin_b - twist / b.inertia,
        ),
    )
