"""Tangential compliance: parts of the contact stick and store energy while others slip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import (
    Body,
    Encounter,
    Operator,
    Outcome,
    WaltonLaw,
    inverse_masses,
)
from analysis.effects.contact.spring_slider import Pressing, line_of_springs, rebound, single_spring
from analysis.effects.effect import ContactEffect, Parameter, Values

STIFFNESS_RATIO = 6 / 7
"""2 (1 - nu) / (2 - nu) for like spheres of Poisson's ratio 1/4, as in thesis, section 7.1."""
POISSON_RATIO = (2 - 2 * STIFFNESS_RATIO) / (2 - STIFFNESS_RATIO)
OTHER_LAWS: tuple[tuple[float, Pressing], ...] = (
    (0.7, line_of_springs),
    (1.0, line_of_springs),
    (6 / 7, single_spring),
    (0.15, single_spring),
)
"""Harder and softer solids, and the single spring of contact codes: as stiff as a solid of
Poisson's ratio 1/4, and so soft that beta0 comes out as thesis, section 7.1, found it for nylon."""
LAWS: tuple[tuple[float, Pressing], ...] = ((STIFFNESS_RATIO, line_of_springs), *OTHER_LAWS)
"""All of them: ratio of tangential to normal stiffness, and law of contact."""
_NAMES: dict[Pressing, str] = {
    line_of_springs: "springs on a line",
    single_spring: "a single spring",
}
LEAST_FRICTION, LEAST_SPEED = 1e-6, 1e-6
"""Below these nothing sticks anyway; the ratios stay finite."""


def compliant(encounter: Encounter, stiffness_ratio: float, pressing: Pressing) -> Floats:
    """Return the impulse across the normal, kg m/s, of the springs and sliders, shape (S,)."""
    give_n, give_t = inverse_masses(encounter.bodies)
    unit = encounter.mu.clip(min=LEAST_FRICTION) * encounter.approach.clip(min=LEAST_SPEED)
    unit = unit / stiffness_ratio
    speed = encounter.sliding_speed
    chi = stiffness_ratio * give_t / give_n / 2
    after = unit * rebound(speed / unit, chi, encounter.e, pressing)
    return np.asarray((speed - after) / give_t)


def lever_of(bodies: tuple[Body, Body]) -> float:
    """Return 1 + 1/K: inverse effective mass across the normal over that along it."""
    along, across = inverse_masses(bodies)
    return across / along


def friction_reach(law: WaltonLaw, lever: float) -> float:
    """Return mu (1 + e) (1 + 1/K), what friction takes off v_s / |v_n| at most."""
    return law.mu * (1 + law.e) * lever


def walton_curve(law: WaltonLaw, lever: float, x: Floats) -> Floats:
    """Return v_s' / |v_n| of equations (7-1) at v_s / |v_n|; `lever` is that of `lever_of`."""
    return np.asarray(np.maximum(-law.beta0 * x, x - friction_reach(law, lever)))


def maw_curve(e: float, mu: float, lever: float, x: Floats) -> Floats:
    """Return v_s' / |v_n| of compliant spheres (N. Maw et al., Wear 38, 101 (1976)), same e and mu.

    At v_s / |v_n|, of spheres of `POISSON_RATIO`; `lever` is 1 + 1/K. Not a number without
    friction.
    """
    if not mu > 0:
        return np.full_like(x, np.nan)
    unit = mu / STIFFNESS_RATIO
    return np.asarray(unit * rebound(x / unit, STIFFNESS_RATIO * lever / 2, np.full_like(x, e)))


def effect_at(
    stiffness_ratio: float,
    pressing: Pressing = line_of_springs,
    variants: tuple[ContactEffect, ...] = (),
) -> ContactEffect:
    """Return the effect for one ratio of tangential to normal stiffness and one law of contact."""

    def wrap(operator: Operator, values: Values) -> Operator:
        def changed(encounter: Encounter) -> Outcome:
            def across(met: Encounter) -> Floats:
                stiff, soft = encounter.across(met), compliant(met, stiffness_ratio, pressing)
                return np.asarray((1.0 - values[0]) * stiff + values[0] * soft)

            return operator(replace(encounter, across=across))

        return changed

    return ContactEffect(
        name="tangential-compliance",
        title=f"Tangential compliance, {_NAMES[pressing]}, stiffness ratio {stiffness_ratio:.3g}",
        parameters=(
            Parameter(
                symbol="a",
                unit="1",
                meaning="share of the compliant law: 0 is Walton's, 1 is the full theory",
                plausible=(0.0, 1.3),
                one_sided=True,
            ),
        ),
        formula=(
            "v_s' = (1 - a) Walton + a (mu v_n / kappa) f(kappa v_s / (mu v_n)), "
            f"kappa = {stiffness_ratio:.3g}"
        ),
        source=(
            "N. Maw, J. R. Barber and J. N. Fawcett, Wear 38, 101 (1976) and J. Lubr. Technol. "
            "103, 74 (1981), as springs and sliders on a line; P. A. Cundall and O. D. L. Strack, "
            "Geotechnique 29, 47 (1979), as a single one; each with a dashpot along the normal"
        ),
        gives_away="v_s' bends round the corner of stick and slip, and is positive at small v_s",
        confused_with=("friction-speed", "rolling-restitution-speed", "inertia-factor"),
        variants=variants,
        wrap=wrap,
    )


EFFECT = effect_at(
    STIFFNESS_RATIO, variants=tuple(effect_at(ratio, law) for ratio, law in OTHER_LAWS)
)
