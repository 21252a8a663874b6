"""Normal restitution that depends on how oblique the impact is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

LARGEST_RATIO = 3.0
"""Of v_s to v_n: beyond it e no longer follows, so that a grazing shot does not decide alone."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Scale e by 1 + a min(v_s / v_n, 3)."""

    def changed(encounter: Encounter) -> Outcome:
        slowest = encounter.sliding_speed / LARGEST_RATIO
        ratio = encounter.sliding_speed / np.maximum(encounter.approach, slowest)
        return operator(replace(encounter, e=encounter.e * (1.0 + values[0] * ratio)))

    return changed


EFFECT = ContactEffect(
    name="restitution-obliquity",
    title="Obliquity-dependent restitution",
    parameters=(
        Parameter(
            symbol="a",
            unit="1",
            meaning="relative change of e for each unit of v_s / v_n",
            plausible=(-0.1, 0.1),
        ),
    ),
    formula="e = e0 [1 + a min(v_s / v_n, 3)]",
    source=(
        "M. Y. Louge and M. E. Adams, Phys. Rev. E 65, 021303 (2002); H. Kuninaka and "
        "H. Hayakawa, Phys. Rev. Lett. 93, 154301 (2004)"
    ),
    gives_away="residual of v_n' / v_n follows v_s / v_n at one and the same v_n",
    confused_with=("finite-contact", "pixel-aspect"),
    wrap=wrap,
)
