"""Friction against relative spin about the normal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.collision.operator import Encounter, Operator, Outcome, inverse_masses
from analysis.effects.effect import ContactEffect, Parameter, Values

REFERENCE_SPEED = 2.0
"""m/s: the approach speed at which the radius of contact is the stated one."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Brake the relative spin about the normal by (3 pi / 16) mu c times the normal impulse."""

    def changed(encounter: Encounter) -> Outcome:
        outcome = operator(encounter)
        a, b = encounter.bodies
        before, after, normal = encounter.before, outcome.after, encounter.normal
        approach = encounter.approach.clip(min=0.0)
        radius = values[0] * (approach / REFERENCE_SPEED) ** 0.4
        impulse = (1 + encounter.e) * approach / inverse_masses(encounter.bodies)[0]
        torsion = 3 * np.pi / 16 * encounter.mu * radius * impulse
        relative = ((before.spin_b - before.spin_a) * normal).sum(axis=1)
        stopping = np.abs(relative) / (1 / a.inertia + 1 / b.inertia)
        twist = (np.minimum(torsion, stopping) * np.sign(relative))[:, None] * normal
        return replace(
            outcome,
            after=replace(
                after,
                spin_a=after.spin_a + twist / a.inertia,
                spin_b=after.spin_b - twist / b.inertia,
            ),
        )

    return changed


EFFECT = ContactEffect(
    name="torsional-friction",
    title="Torsional friction",
    parameters=(
        Parameter(
            symbol="c",
            unit="m",
            meaning="radius of contact, mean over the normal impulse, at v_n = 2 m/s",
            plausible=(0.0, 2e-3),
            step=1e-7,
            one_sided=True,
        ),
    ),
    formula="I dw_n = (3 pi / 16) mu c (v_n / 2 m/s)^0.4 J_n, against w_bn - w_an, at most to rest",
    source=(
        "torque of full slip under Hertz's pressure, K. L. Johnson, Contact Mechanics (1985), "
        "section 7.4; Hertz's radius grows as v_n^(2/5), 0.8 mm for nylon at 2 m/s"
    ),
    gives_away="spins about the normal approach each other; nothing else changes them",
    confused_with=("spin-decay",),
    wrap=wrap,
)
