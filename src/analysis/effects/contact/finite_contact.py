"""A contact that lasts: the line of centres turns while the spheres touch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import Encounter, Operator, Outcome, inverse_masses
from analysis.effects.effect import ContactEffect, Parameter, Values

PLANE_MODULUS = 3.0e9 / (1.0 - 0.4**2)
"""Pa, E / (1 - nu^2) of nylon: the modulus of a = 1."""
LEAST_SPEED = 0.02
"""m/s; a slower contact is taken to last as long as at this speed."""
Striking = Callable[[Operator, Encounter, Encounter], Outcome]
"""Lets an operator act, given the encounter at first touch and that about the mean normal."""
PASSES = 3
"""Of the direction of the impulse, which depends on the impulse itself."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Let the operator act about the mean normal of the contact, and the spheres leave later.

    Friction acts against the slip at first touch. About the mean normal part of the approach would
    count as slip; but the approach turns into a rebound while the normal turns, and the two nearly
    cancel. The normal of a plate does not turn: there nothing changes.
    """
    return _lasting(operator, values, _as_touched)


def wrap_as_it_turns(operator: Operator, values: Values) -> Operator:
    """Do the same with the slip about the mean normal, which springs of a contact follow."""
    return _lasting(operator, values, _as_it_turns)


def _lasting(operator: Operator, values: Values, struck: Striking) -> Operator:
    def changed(encounter: Encounter) -> Outcome:
        if encounter.bodies[1].is_plate or values[0] == 0.0:
            return operator(encounter)
        lasts = values[0] * hertz_time(encounter) * _damped(encounter.e)
        outcome = operator(encounter)
        for _ in range(PASSES):
            mean = _about_mean_normal(encounter, outcome, lasts)
            outcome = struck(operator, encounter, mean)
        return _leaving(encounter, _with_short_levers(encounter, outcome, lasts), lasts)

    return changed


def _as_it_turns(operator: Operator, first: Encounter, mean: Encounter) -> Outcome:
    del first
    return operator(mean)


def _as_touched(operator: Operator, first: Encounter, mean: Encounter) -> Outcome:
    """Let the operator meet the first slip, laid into the mean plane, and take it out again."""
    slip = first.sliding
    laid = slip - (slip * mean.normal).sum(axis=1, keepdims=True) * mean.normal
    length = np.sqrt(np.maximum((laid**2).sum(axis=1), 1e-30))
    extra = laid * (first.sliding_speed / length)[:, None] - mean.sliding
    moved = replace(mean.before, velocity_b=mean.before.velocity_b + extra)
    outcome = operator(replace(mean, before=moved))
    after = replace(outcome.after, velocity_b=outcome.after.velocity_b - extra)
    return replace(outcome, after=after)


def hertz_time(encounter: Encounter) -> Floats:
    """Return Hertz's duration of an elastic nylon contact, s, shape (S,).

    2.9432 x_max / v_n with x_max = (5 m* v_n^2 / (4 k))^(2/5), k = (4/3) E* sqrt(R*).
    """
    a, b = encounter.bodies
    radius = 1 / (1 / a.radius + 1 / b.radius)
    stiffness = 4 / 3 * PLANE_MODULUS / 2 * np.sqrt(radius)
    speed = encounter.approach.clip(min=LEAST_SPEED)
    deepest = (5 * speed**2 / (4 * stiffness * inverse_masses(encounter.bodies)[0])) ** 0.4
    return np.asarray(2.9432 * deepest / speed)


def centroid(e: Floats) -> Floats:
    """Return the mean time of the normal force as a share of the contact: 1/2 when elastic.

    Fitted to Hertz's force with damping as x^(1/4), followed until the overlap is gone.
    """
    loss = 1 - e
    return np.asarray(0.5 - 0.25 * loss - 0.155 * loss**2)


def _damped(e: Floats) -> Floats:
    """Return by what factor the same damping prolongs the contact."""
    return np.asarray(1 + 0.1 * (1 - e) + 0.17 * (1 - e) ** 2)


def _about_mean_normal(encounter: Encounter, outcome: Outcome, lasts: Floats) -> Encounter:
    """Return the encounter about the force's mean normal, with the size of impulse corrected."""
    distance = _mean_distance(encounter, lasts)
    first, last = _crosswise(encounter, outcome)
    # 1/9: mean share of a sliding contact's tangential impulse times time, for a sin^1.5 pulse.
    moved = centroid(encounter.e)[:, None] * first + (last - first) / 9
    tilted = replace(
        encounter, normal=_turned(encounter.normal, moved * (lasts / distance)[:, None])
    )
    turning = (first * (first + last)).sum(axis=1) * lasts / distance
    held = encounter.approach - 0.25 * turning
    stated = tilted.approach
    ratio = np.where(stated > LEAST_SPEED, held.clip(min=0.0) / stated.clip(min=LEAST_SPEED), 1.0)
    return replace(tilted, e=encounter.e + (1 + encounter.e) * (ratio - 1))


def _overlap(encounter: Encounter, lasts: Floats) -> Floats:
    """Return the deepest overlap, m: v_n t_c / 2.94 (Hertz), shape (S,)."""
    return np.asarray(encounter.approach.clip(min=LEAST_SPEED) * lasts / 2.9432)


def _mean_distance(encounter: Encounter, lasts: Floats) -> Floats:
    """Return how far apart the centres are while they turn, m: the radii less the mean overlap.

    The overlap goes as sin(pi t / t_c), 2 / pi of its largest in the mean.
    """
    a, b = encounter.bodies
    return np.asarray(a.radius + b.radius - 2 / np.pi * _overlap(encounter, lasts))


def _with_short_levers(encounter: Encounter, outcome: Outcome, lasts: Floats) -> Outcome:
    """Return the outcome with spins changed at the levers that are left: half the overlap is gone.

    Weighted with the force, as sin^(3/2), the overlap is 0.823 of its largest.
    """
    before, after = encounter.before, outcome.after
    half = 0.823 / 2 * _overlap(encounter, lasts)[:, None]
    a, b = encounter.bodies
    spin_a = after.spin_a - half / a.radius * (after.spin_a - before.spin_a)
    spin_b = after.spin_b - half / b.radius * (after.spin_b - before.spin_b)
    return replace(outcome, after=replace(after, spin_a=spin_a, spin_b=spin_b))


def _leaving(encounter: Encounter, outcome: Outcome, lasts: Floats) -> Outcome:
    """Return the outcome with the way and the turns of the contact's duration added."""
    a, b = encounter.bodies
    before, after = encounter.before, outcome.after
    first, last = _crosswise(encounter, outcome)
    early = centroid(encounter.e)[:, None]
    distance, time = a.radius + b.radius, lasts[:, None]
    across = (early * first + (1 - early) * last) * time / distance
    swing = distance * (_turned(encounter.normal, across) - encounter.normal)
    share_a = a.mass / (a.mass + b.mass)
    drift = (share_a * before.velocity_a + (1 - share_a) * before.velocity_b) * time
    return replace(
        outcome,
        duration=outcome.duration + lasts,
        shift_a=outcome.shift_a + drift - (1 - share_a) * swing,
        shift_b=outcome.shift_b + drift + share_a * swing,
        turn_a=outcome.turn_a + (early * before.spin_a + (1 - early) * after.spin_a) * time,
        turn_b=outcome.turn_b + (early * before.spin_b + (1 - early) * after.spin_b) * time,
    )


def _crosswise(encounter: Encounter, outcome: Outcome) -> tuple[Floats, Floats]:
    """Return the relative velocities of the centres across the normal, before and after."""
    normal, pair = encounter.normal, []
    for state in (encounter.before, outcome.after):
        relative = state.velocity_b - state.velocity_a
        along = (relative * normal).sum(axis=1, keepdims=True)
        pair.append(relative - along * normal)
    return pair[0], pair[1]


def _turned(normal: Floats, angle: Floats) -> Floats:
    """Turn unit vectors by small angles across them, rad, shape (S, 3)."""
    size = np.sqrt((angle**2).sum(axis=1, keepdims=True))
    return np.asarray(normal * np.cos(size) + angle * np.sinc(size / np.pi))


def effect_with(
    title: str,
    wrapped: Callable[[Operator, Values], Operator],
    variants: tuple[ContactEffect, ...] = (),
) -> ContactEffect:
    """Return the effect with one way to count the slip that friction reverses."""
    return ContactEffect(
        name="finite-contact",
        title=title,
        parameters=(
            Parameter(
                symbol="a",
                unit="1",
                meaning="duration of contact in Hertz's for 3 GPa and Poisson's ratio 0.4",
                plausible=(0.0, 1.5),
                one_sided=True,
            ),
        ),
        formula=(
            "impulse (1 + e) m* [v_n - v_t (v_t + v_t') t_c / (4 D)] about "
            "n + (c v_t + dv_t / 9) t_c / D, "
            "separation at t_c = a t_Hertz(v_n) along the line of centres turned meanwhile"
        ),
        source=(
            "P. Mueller and T. Poeschel, Granular Matter 14, 115 (2012); centroid c of the "
            "impulse and prolongation by damping from the contact law of Y. Tsuji, T. Tanaka and "
            "T. Ishida, Powder Technol. 71, 239 (1992)"
        ),
        gives_away=(
            "oblique shots: e too small by (1 + e) v_t^2 t_c / (2 D v_n), centres leave late"
        ),
        confused_with=("image-scale", "radius-mismatch", "restitution-obliquity", "pixel-aspect"),
        wrap=wrapped,
        variants=variants,
    )


EFFECT = effect_with(
    "Finite contact duration",
    wrap,
    (effect_with("Finite contact duration, slip as it turns", wrap_as_it_turns),),
)
