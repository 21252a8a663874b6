"""A constant offset of the speed of separation."""

from __future__ import annotations

from dataclasses import replace

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

LEAST_SPEED = 0.05
"""m/s; slower shots would turn a small offset into any restitution."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Add u to the speed of separation."""

    def changed(encounter: Encounter) -> Outcome:
        speed = encounter.approach.clip(min=LEAST_SPEED)
        return operator(replace(encounter, e=encounter.e + values[0] / speed))

    return changed


EFFECT = ContactEffect(
    name="velocity-offset",
    title="Constant velocity offset",
    parameters=(
        Parameter(
            symbol="u",
            unit="m/s",
            meaning="speed of separation above e v_n",
            plausible=(-0.05, 0.05),
        ),
    ),
    formula="v_n' = e v_n + u",
    source=(
        "the general linear form of v_n' against v_n; bias of edges or of one-sided fits leaves "
        "such an offset (thesis, section 5.1)"
    ),
    gives_away="v_n' against v_n is straight and misses the origin",
    confused_with=("restitution-plastic", "restitution-viscoelastic", "adhesion"),
    wrap=wrap,
)
