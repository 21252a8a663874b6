"""Normal restitution that drifts in the course of a campaign."""

from __future__ import annotations

from dataclasses import replace

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values


def wrap(operator: Operator, values: Values) -> Operator:
    """Scale e by 1 + a t, t from -1/2 at the first shot to 1/2 at the last."""

    def changed(encounter: Encounter) -> Outcome:
        factor = 1.0 + values[0] * encounter.covariates["order"]
        return operator(replace(encounter, e=encounter.e * factor))

    return changed


EFFECT = ContactEffect(
    name="restitution-drift",
    title="Drift of restitution",
    parameters=(
        Parameter(
            symbol="a",
            unit="1",
            meaning="relative change of e from the first shot to the last",
            plausible=(-0.05, 0.05),
        ),
    ),
    formula="e = e0 (1 + a t), t from -1/2 to 1/2 in the order of firing",
    source=(
        "warming, wear and moisture of nylon; linear in the order of firing as the first term of "
        "any slow change"
    ),
    gives_away="residual of v_n' / v_n follows the order of firing",
    confused_with=("restitution-viscoelastic", "restitution-plastic"),
    wrap=wrap,
)
