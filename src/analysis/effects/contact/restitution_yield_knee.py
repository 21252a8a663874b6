"""Restitution that is constant up to a yield speed and falls with a power of the speed above."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

YIELD_SPEED = 2.0
"""m/s; nylon of 2.3 GPa that yields at 70 MPa."""
OTHER_YIELD_SPEEDS = (0.5, 0.74, 1.0, 1.4, 2.8)


def effect_at(yield_speed: float, variants: tuple[ContactEffect, ...] = ()) -> ContactEffect:
    """Return the effect with its knee at a yield speed, m/s.

    The knee itself cannot be fitted from where the effect is off: without a fall above the knee
    it has no place. It is therefore held, and other places are variants.
    """

    def wrap(operator: Operator, values: Values) -> Operator:
        def changed(encounter: Encounter) -> Outcome:
            beyond = np.maximum(encounter.approach / yield_speed, 1.0)
            return operator(replace(encounter, e=encounter.e * beyond ** -values[0]))

        return changed

    return ContactEffect(
        name="restitution-yield-knee",
        title=f"Restitution with a yield knee at {yield_speed:g} m/s",
        parameters=(
            Parameter(
                symbol="p",
                unit="1",
                meaning="power by which e falls with the approach speed above the yield speed",
                plausible=(0.0, 0.25),
            ),
        ),
        formula=f"e = e0 max(1, v_n / v_y)^-p, v_y = {yield_speed:g} m/s",
        source=(
            "C. Thornton, J. Appl. Mech. 64, 383 (1997): e = 1 below v_y, towards v^(-1/4) above; "
            "m* v_y^2 / 2 = 53 R*^3 Y^5 / E*^4, K. L. Johnson, Contact Mechanics (1985), "
            "section 11.5: 0.7 to 2 m/s for nylon"
        ),
        gives_away="e is level at low v_n and falls beyond one speed",
        confused_with=("restitution-plastic", "restitution-viscoelastic"),
        variants=variants,
        wrap=wrap,
    )


EFFECT = effect_at(YIELD_SPEED, tuple(effect_at(speed) for speed in OTHER_YIELD_SPEEDS))
