"""Two spheres that do not have the stated ratio of masses."""

from __future__ import annotations

from dataclasses import replace

from analysis.collision.operator import Body, Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values


def wrap(operator: Operator, values: Values) -> Operator:
    """Scale the mass of a by 1 + d and that of b by 1 - d, and their inertia with them."""

    def scaled(body: Body, factor: float) -> Body:
        return replace(body, mass=body.mass * factor, inertia=body.inertia * factor)

    def changed(encounter: Encounter) -> Outcome:
        (a, b), d = encounter.bodies, float(values[0])
        return operator(replace(encounter, bodies=(scaled(a, 1.0 + d), scaled(b, 1.0 - d))))

    return changed


EFFECT = ContactEffect(
    name="mass-mismatch",
    title="Mass mismatch",
    parameters=(
        Parameter(
            symbol="d",
            unit="1",
            meaning="(m_a - m_b) / (m_a + m_b), above what is stated",
            plausible=(-0.02, 0.02),
        ),
    ),
    formula="change of (v_a + v_b) / 2 = (d / 2) times change of v_b - v_a, when stated equal",
    source="conservation of momentum; moulded nylon balls of one inch weigh alike to 1 or 2 %",
    gives_away="the mean velocity of both spheres jumps along the normal at contact",
    confused_with=("radius-mismatch", "mirror-angle"),
    wrap=wrap,
    of_pairs=True,
)
