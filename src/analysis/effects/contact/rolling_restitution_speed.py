"""Rotational restitution that depends on the approach speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

REFERENCE_SPEED = 2.0
"""m/s, in the middle of this rig's range: there beta0 keeps its meaning."""
LEAST_SPEED = 0.01
"""m/s; the logarithm would run away below."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Scale beta0 by 1 + a ln(v_n / v0)."""

    def changed(encounter: Encounter) -> Outcome:
        speed = encounter.approach.clip(min=LEAST_SPEED)
        factor = 1.0 + values[0] * np.log(speed / REFERENCE_SPEED)
        return operator(replace(encounter, beta0=encounter.beta0 * factor))

    return changed


EFFECT = ContactEffect(
    name="rolling-restitution-speed",
    title="Speed-dependent rotational restitution",
    parameters=(
        Parameter(
            symbol="a",
            unit="1",
            meaning="relative change of beta0 for an approach speed e = 2.718 times as large",
            plausible=(-0.5, 0.5),
        ),
    ),
    formula="beta0 = beta00 [1 + a ln(v_n / v0)], v0 = 2 m/s",
    source=(
        "phenomenological; what a constant beta0 (thesis, section 7.1) leaves of tangential "
        "compliance with damping, first term in ln v_n"
    ),
    gives_away="residual of v_s' / v_s in sticking shots follows v_n",
    confused_with=("tangential-compliance",),
    wrap=wrap,
)
