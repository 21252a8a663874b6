"""A moment of inertia other than that of the stated body."""

from __future__ import annotations

from dataclasses import replace

from analysis.collision.operator import Body, Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values


def wrap(operator: Operator, values: Values) -> Operator:
    """Scale both moments of inertia by 1 + k."""

    def heavier(body: Body) -> Body:
        return replace(body, inertia=body.inertia * (1.0 + float(values[0])))

    def changed(encounter: Encounter) -> Outcome:
        a, b = encounter.bodies
        return operator(replace(encounter, bodies=(heavier(a), heavier(b))))

    return changed


EFFECT = ContactEffect(
    name="inertia-factor",
    title="Inertia factor",
    parameters=(
        Parameter(
            symbol="k",
            unit="1",
            meaning="relative change of both moments of inertia; 2/3 for a shell stated as solid",
            plausible=(-0.15, 0.67),
        ),
    ),
    formula="I = (1 + k) I0, I0 = 0.4 m R^2 when solid",
    source="K = 4 I / (m D^2) of O. R. Walton (1993) and thesis, section 7.1; a thin shell has 2/3",
    gives_away="change of spin against change of v_t, which K alone fixes",
    confused_with=("tangential-compliance", "radius-mismatch"),
    wrap=wrap,
)
