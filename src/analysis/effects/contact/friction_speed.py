"""Friction that depends on the sliding speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

REFERENCE_SPEED = 1.0
"""m/s, in the middle of this rig's range: there mu keeps its meaning."""
LEAST_SPEED = 0.01
"""m/s; slower contacts stick, and the logarithm would run away."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Scale mu by 1 + a ln(v_s / v_ref)."""

    def changed(encounter: Encounter) -> Outcome:
        speed = encounter.sliding_speed.clip(min=LEAST_SPEED)
        factor = 1.0 + values[0] * np.log(speed / REFERENCE_SPEED)
        return operator(replace(encounter, mu=encounter.mu * factor))

    return changed


EFFECT = ContactEffect(
    name="friction-speed",
    title="Speed-dependent friction",
    parameters=(
        Parameter(
            symbol="a",
            unit="1",
            meaning="relative change of mu for a sliding speed e = 2.718 times as large",
            plausible=(-0.2, 0.2),
        ),
    ),
    formula="mu = mu0 [1 + a ln(v_s / v_ref)], v_ref = 1 m/s",
    source=(
        "first term of a power law or of a Stribeck curve about v_ref; dependence on v_s in "
        "impacts of spheres: J. Appl. Mech. 76, 031015 (2009)"
    ),
    gives_away="mu from sliding shots follows ln v_s",
    confused_with=("friction-drift", "tangential-compliance"),
    wrap=wrap,
)
