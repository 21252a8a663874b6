"""Adhesion: work lost in pulling the surfaces apart."""

from __future__ import annotations

from dataclasses import replace

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

LEAST_SPEED = 0.05
"""m/s; the form is the first term in (v_st / v_n)^2, and no campaign here is slower."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Take a / v_n from the speed of separation."""

    def changed(encounter: Encounter) -> Outcome:
        speed = encounter.approach.clip(min=LEAST_SPEED)
        return operator(replace(encounter, e=encounter.e - values[0] / speed**2))

    return changed


EFFECT = ContactEffect(
    name="adhesion",
    title="Adhesion",
    parameters=(
        Parameter(
            symbol="a",
            unit="m^2/s^2",
            meaning="speed of separation lost times the approach speed",
            plausible=(0.0, 1e-6),
            one_sided=True,
        ),
    ),
    formula="v_n' = e v_n - a / v_n, a about v_st^2 / (2 e)",
    source=(
        "C. Thornton and Z. Ning, Powder Technol. 99, 154 (1998): v_st = 1.84 (Gamma^5 R*^4 / "
        "(m*^3 E*^2))^(1/6), 1e-4 m/s for nylon with Gamma = 0.08 J/m^2, unseen on this rig"
    ),
    gives_away="e falls towards the slowest impacts, as 1 / v_n^2",
    confused_with=("velocity-offset", "restitution-plastic", "restitution-viscoelastic"),
    wrap=wrap,
)
