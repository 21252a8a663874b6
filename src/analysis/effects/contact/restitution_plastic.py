"""Restitution of bodies that yield: a power law of the approach speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

REFERENCE_SPEED = 2.0
"""m/s, in the middle of this rig's range: there e keeps its meaning."""
LEAST_SPEED = 1e-3
"""m/s; below it a contact is as good as none, and the power is not followed."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Scale e by (v / v0)^-p; never to more than 1, where the contact no longer yields."""

    def changed(encounter: Encounter) -> Outcome:
        speed = encounter.approach.clip(min=LEAST_SPEED)
        factor = (speed / REFERENCE_SPEED) ** -values[0]
        e = np.minimum(encounter.e * factor, np.maximum(encounter.e, 1.0))
        return operator(replace(encounter, e=e))

    return changed


EFFECT = ContactEffect(
    name="restitution-plastic",
    title="Plastic restitution",
    parameters=(
        Parameter(
            symbol="p",
            unit="1",
            meaning="power by which e falls with the approach speed; 1/4 when all is plastic",
            plausible=(0.0, 0.25),
        ),
    ),
    formula="e = min[1, e0 (v_n / v0)^-p], v0 = 2 m/s",
    source=(
        "K. L. Johnson, Contact Mechanics (1985), section 11.5: e ~ v^(-1/4) well above yield, and "
        "C. Thornton, J. Appl. Mech. 64, 383 (1997); nylon yields from about 1 m/s on"
    ),
    gives_away="ln v_n' against ln v_n is straight, with a slope below one",
    confused_with=("restitution-viscoelastic", "restitution-yield-knee", "velocity-offset"),
    wrap=wrap,
)
