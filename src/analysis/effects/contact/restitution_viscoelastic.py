"""Restitution of a viscoelastic contact: faster collisions lose more."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from analysis.arrays import Floats
from analysis.collision.force_law import KUWABARA_KONO, REFERENCE_SPEED
from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

LEAST_SPEED = 1e-3


def wrap(operator: Operator, values: Values) -> Operator:
    """Let e fall with speed as for viscoelastic spheres, scaled to the slope.

    e = e0 [E(gamma0 (v / v0)^(1/5)) / E(gamma0)]^q with E(gamma0) = e0: q = 1 is a contact that
    loses by viscosity alone, and the slope at v0 is a.
    """

    def changed(encounter: Encounter) -> Outcome:
        # Compiled functions are loaded only where contacts are integrated.
        from analysis.collision.damping import DAMPINGS, damping, restitution  # noqa: PLC0415

        lost, whole = damping(encounter.e, KUWABARA_KONO), _slopes()
        speed = encounter.approach.clip(min=LEAST_SPEED) / REFERENCE_SPEED
        share = values[0] / np.interp(lost, DAMPINGS, whole)
        faster = lost * speed**KUWABARA_KONO.loss_exponent
        ratio = restitution(faster, KUWABARA_KONO) / restitution(lost, KUWABARA_KONO)
        return operator(replace(encounter, e=encounter.e * ratio**share))

    return changed


@cache
def _slopes() -> Floats:
    """Return the slope a of a contact that loses by viscosity alone, by damping."""
    from analysis.collision.damping import DAMPINGS, restitution  # noqa: PLC0415

    fall = -np.gradient(np.log(restitution(DAMPINGS, KUWABARA_KONO)), DAMPINGS) * DAMPINGS
    fall[0] = fall[1]
    power = KUWABARA_KONO.loss_exponent
    return np.asarray(power * REFERENCE_SPEED**-power * fall)


EFFECT = ContactEffect(
    name="restitution-viscoelastic",
    title="Viscoelastic restitution",
    parameters=(
        Parameter(
            symbol="a",
            unit="(m/s)^-0.2",
            meaning="loss of e for each unit of (v^0.2 - v0^0.2) / 0.2 about v0 = 2 m/s",
            plausible=(0.0, 0.2),
        ),
    ),
    formula=(
        f"e = e0 [1 - a (v_n^0.2 - v0^0.2) / 0.2 + ...], v0 = {REFERENCE_SPEED:g} m/s; "
        "as a whole e0 E(gamma) / E(gamma0)"
    ),
    source=(
        "G. Kuwabara and K. Kono, Jpn. J. Appl. Phys. 26, 1230 (1987); R. Ramirez, T. Poeschel, "
        "N. V. Brilliantov and T. Schwager, Phys. Rev. E 60, 4465 (1999): e = 1 - 1.15345 gamma, "
        "gamma ~ v^(1/5); force gone before the overlap: T. Schwager and T. Poeschel, Phys. Rev. "
        "E 78, 051304 (2008)"
    ),
    gives_away="residual of v_n' falls with v_n, gently and without a knee",
    confused_with=("restitution-plastic", "restitution-yield-knee"),
    wrap=wrap,
)
