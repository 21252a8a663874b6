"""A contact that lasts: forces along and across the normal, integrated from touch to parting."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.force_law import (
    CONSTANT_DASHPOT,
    LINEAR,
    TSUJI,
    VISCOUS,
    ForceLaw,
    hertz_duration,
)
from analysis.collision.operator import Body, Encounter, Operator, Outcome, States
from analysis.effects.effect import ContactEffect, ContactLaw, Parameter, Values

FAMILIES = (
    ForceLaw(TSUJI, "elongation"),
    ForceLaw(TSUJI, "elongation", shortened=False),
    ForceLaw(TSUJI, "increment"),
    ForceLaw(TSUJI, "increment", dashpot_slides=False),
    ForceLaw(LINEAR, "elongation"),
    ForceLaw(LINEAR, "elongation", shortened=False),
    ForceLaw(LINEAR, "increment", dashpot_slides=False),
)
"""The laws of contact that simulation codes use.

Springs whose stiffness does not change have one history: increments are no law of their own there.
"""
TYPICAL_MODULUS = 1.8e9
"""Pa, E* of two nylon spheres: what the shares of a mixture are scored with."""
TYPICAL = ((0.15, 0.05), (0.85, 0.05))
"""Stiffness ratio and tangential damping of a soft and of a Mindlin spring."""


def law_of(force: ForceLaw, values: Values, steps: int | None = None) -> Operator:
    """Return the operator of a force law at a duration (s), stiffness ratio and damping.

    Each a number, or one for each encounter: values of shape (3,) or (3, N). It is integrated in so
    many steps; None: as many as suffice for the errors of measured shots.
    """
    duration, ratio, damping = values

    def operator(encounter: Encounter) -> Outcome:
        # Compiled functions are loaded only where contacts are integrated.
        from analysis.collision.lasting import Stiffness, lasting  # noqa: PLC0415

        return lasting(encounter, force, Stiffness(duration, ratio, damping), steps)

    return operator


def contact_modulus(duration_s: float, bodies: tuple[Body, Body]) -> float:
    """Return the contact modulus E*, Pa, whose undamped contact lasts so long at 1 m/s."""
    return float((hertz_duration(1.0, bodies) / duration_s) ** 2.5)


def share_at(force: ForceLaw, ratio: float, damping: float) -> ContactEffect:
    """Return the effect that mixes a law at typical values into the operator by a share."""

    def wrap(operator: Operator, values: Values) -> Operator:
        def changed(encounter: Encounter) -> Outcome:
            duration = hertz_duration(TYPICAL_MODULUS, encounter.bodies)
            soft = law_of(force, np.array([duration, ratio, damping]))(encounter)
            return _mixed(operator(encounter), soft, float(values[0]))

        return changed

    return ContactEffect(
        name=NAME,
        title=f"Contact that lasts, {force.title}, stiffness ratio {ratio:g}",
        parameters=(
            Parameter(
                symbol="share",
                unit="1",
                meaning="share of the lasting contact: 0 is the hard-sphere law, 1 is the full one",
                plausible=(0.0, 10.0),
                one_sided=True,
            ),
        ),
        formula="outcome = (1 - share) hard spheres + share lasting contact",
        source="embedding of a law that does not contain the other",
        gives_away=GIVES_AWAY,
        contains=CONTAINED,
        wrap=wrap,
    )


def _mixed(first: Outcome, second: Outcome, share: float) -> Outcome:
    """Return the outcome between two, number by number."""

    def between(a: Floats, b: Floats) -> Floats:
        return np.asarray((1.0 - share) * a + share * b)

    one, other = first.after, second.after
    names = ("velocity_a", "velocity_b", "spin_a", "spin_b")
    return Outcome(
        States(*(between(getattr(one, n), getattr(other, n)) for n in names)),
        between(first.duration, second.duration),
        between(first.shift_a, second.shift_a),
        between(first.shift_b, second.shift_b),
        between(first.turn_a, second.turn_a),
        between(first.turn_b, second.turn_b),
    )


NAME = "lasting-contact"
CONTAINED = ("tangential-compliance", "finite-contact", "rolling-restitution-speed")
GIVES_AWAY = (
    "oblique shots: e too small by (1 + e) v_t^2 t_c / (2 D v_n), centres leave late, "
    "v_s' bends round the corner of stick and slip"
)


def effect_of(force: ForceLaw) -> ContactLaw:
    """Return the effect with one force law.

    What Hertz's force and a tangential spring make of a contact hardly depends on the damping, so
    that other dampings are fitted beside the likeliest family alone. With a constant dashpot e
    rises with speed, which no effect of restitution does. With that of Kuwabara and Kono e is as it
    is asked for: that it falls with speed keeps the name of `restitution-viscoelastic`.
    """
    others = (CONSTANT_DASHPOT, VISCOUS) if force.normal is TSUJI else ()
    beside = [effect_of(replace(force, normal=other)) for other in others]
    return ContactLaw(
        beside=tuple(beside),
        name=NAME,
        title=f"Contact that lasts, {force.title}",
        parameters=(
            Parameter(
                symbol="t",
                unit="s",
                meaning="duration of an undamped contact at an approach of 1 m/s",
                plausible=(5e-7, 2e-2),
                step=5e-8,
                possible=(5e-8, 0.1),
            ),
            Parameter(
                symbol="kappa",
                unit="1",
                meaning="tangential over normal stiffness, kt/kn; 2(1 - nu)/(2 - nu) by Mindlin",
                plausible=(0.03, 1.4),
                step=2e-4,
                possible=(0.005, 20.0),
            ),
            Parameter(
                symbol="zeta",
                unit="1",
                meaning="tangential damping over its critical value",
                plausible=(0.0, 0.6),
                step=2e-4,
                possible=(0.0, 3.0),
            ),
        ),
        formula=(
            "m* u' = N n + F, N = k x^p - c x^q u.n, F = -kappa (dN/dx) spring - dashpot, "
            f"|F| <= mu N; p = {force.normal.elastic:g}, q = {force.normal.damping:g}"
        ),
        source=(
            "P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979); Y. Tsuji, T. Tanaka "
            "and T. Ishida, Powder Technol. 71, 239 (1992); turning line of centres: P. Mueller "
            "and T. Poeschel, Granular Matter 14, 115 (2012)"
        ),
        gives_away=GIVES_AWAY,
        confused_with=("friction-speed", "restitution-obliquity", "inertia-factor"),
        contains=CONTAINED,
        law=lambda values: law_of(force, values),
        stepped=lambda values, steps: law_of(force, values, steps),
        shares=SHARES,
    )


SHARES = tuple(share_at(ForceLaw(TSUJI, "elongation"), *typical) for typical in TYPICAL)


def _with_akin(force: ForceLaw) -> tuple[ContactLaw, ...]:
    """Return the effect of a force law, and those of the families that differ little from it.

    The same elastic force with the same history; springs on a line have one.
    """
    near = [
        effect_of(other)
        for other in FAMILIES
        if other != force
        and other.normal is force.normal
        and (other.history == force.history or force.normal is LINEAR)
    ]
    return replace(effect_of(force), akin=tuple(near)), *near


EFFECT, *_OTHERS = (
    law
    for force in (
        ForceLaw(TSUJI, "elongation"),
        ForceLaw(TSUJI, "increment"),
        ForceLaw(LINEAR, "elongation"),
    )
    for law in _with_akin(force)
)
EFFECT = replace(EFFECT, variants=tuple(_OTHERS))
