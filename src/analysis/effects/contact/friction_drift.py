"""Friction that drifts in the course of a campaign."""

from __future__ import annotations

from dataclasses import replace

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values


def wrap(operator: Operator, values: Values) -> Operator:
    """Scale mu by 1 + a t, t from -1/2 at the first shot to 1/2 at the last."""

    def changed(encounter: Encounter) -> Outcome:
        factor = 1.0 + values[0] * encounter.covariates["order"]
        return operator(replace(encounter, mu=encounter.mu * factor))

    return changed


EFFECT = ContactEffect(
    name="friction-drift",
    title="Drift of friction",
    parameters=(
        Parameter(
            symbol="a",
            unit="1",
            meaning="relative change of mu from the first shot to the last",
            plausible=(-0.5, 0.5),
        ),
    ),
    formula="mu = mu0 (1 + a t), t from -1/2 to 1/2 in the order of firing",
    source=(
        "polishing, dust and ink of the markers; linear in the order of firing as the first term "
        "of any slow change"
    ),
    gives_away="residual of v_s' in sliding shots follows the order of firing",
    confused_with=("friction-speed",),
    wrap=wrap,
)
