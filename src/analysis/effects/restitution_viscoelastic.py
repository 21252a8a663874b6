"""Restitution that falls with the fifth root of the approach speed."""

from __future__ import annotations

from dataclasses import replace

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

REFERENCE_SPEED = 2.0
"""m/s, in the middle of this rig's range: there e keeps its meaning."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Scale e by 1 - a (v^0.2 - v0^0.2) / 0.2."""

    def changed(encounter: Encounter) -> Outcome:
        speed = encounter.approach.clip(min=0.0)
        factor = 1.0 - values[0] * (speed**0.2 - REFERENCE_SPEED**0.2) / 0.2
        return operator(replace(encounter, e=encounter.e * factor))

    return changed


EFFECT = ContactEffect(
    name="restitution-viscoelastic",
    title="Viscoelastic restitution",
    parameters=(
        Parameter(
            symbol="a",
            unit="(m/s)^-0.2",
            meaning="loss of e for each unit of (v^0.2 - v0^0.2) / 0.2, v0 = 2 m/s",
            plausible=(0.0, 0.08),
        ),
    ),
    formula="e = e0 [1 - a (v_n^0.2 - v0^0.2) / 0.2]",
    source=(
        "G. Kuwabara and K. Kono, Jpn. J. Appl. Phys. 26, 1230 (1987); R. Ramirez, T. Poeschel, "
        "N. V. Brilliantov and T. Schwager, Phys. Rev. E 60, 4465 (1999): e = 1 - 1.15345 gamma, "
        "gamma ~ v^(1/5)"
    ),
    gives_away="residual of v_n' falls with v_n, gently and without a knee",
    confused_with=("restitution-plastic", "restitution-yield-knee"),
    wrap=wrap,
)
