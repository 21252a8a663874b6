"""Restitution of a viscoelastic contact: faster collisions lose more."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from analysis.collision.operator import Encounter, Floats, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

REFERENCE_SPEED = 2.0
LEAST_SPEED = 1e-3
_DAMPINGS = np.linspace(0.0, 2.0, 201)
_STEP, _STEPS = 2e-3, 3000


def wrap(operator: Operator, values: Values) -> Operator:
    """Let e fall with speed as viscoelastic spheres' does, in the share that the slope asks for.

    e = e0 [E(gamma0 (v / v0)^(1/5)) / E(gamma0)]^q with E(gamma0) = e0: q = 1 is a contact that
    loses by viscosity alone, and the slope at v0 is a.
    """

    def changed(encounter: Encounter) -> Outcome:
        damping, whole = np.interp(encounter.e, *_inverse()), _slopes()
        speed = (encounter.approach.clip(min=LEAST_SPEED) / REFERENCE_SPEED) ** 0.2
        share = values[0] / np.interp(damping, _DAMPINGS, whole)
        ratio = restitution(damping * speed) / restitution(damping)
        return operator(replace(encounter, e=encounter.e * ratio**share))

    return changed


def restitution(damping: Floats) -> Floats:
    """Return e of x'' = -x^(3/2) - gamma x^(1/2) x', from first touch until the force is gone.

    In units of Hertz's time and depth; gamma = (3/2) A (k / m*)^(2/5) v^(1/5), shape (...).
    """
    return np.asarray(np.interp(damping, _DAMPINGS, _table()))


@cache
def _table() -> Floats:
    """Integrate the contact for every damping at once (classical Runge-Kutta)."""
    depth, speed = np.zeros_like(_DAMPINGS), np.ones_like(_DAMPINGS)
    left = np.full_like(_DAMPINGS, np.nan)
    force = np.zeros_like(_DAMPINGS)
    for _ in range(_STEPS):
        before, last = force, speed
        depth, speed = _advanced(depth, speed)
        force = depth.clip(min=0.0) + _DAMPINGS * speed
        gone = np.isnan(left) & (force <= 0) & (speed < 0)
        part = before / np.where(gone, before - force, 1.0)
        left = np.where(gone, -(last + part * (speed - last)), left)
    return left


def _advanced(depth: Floats, speed: Floats) -> tuple[Floats, Floats]:
    def rate(x: Floats, v: Floats) -> Floats:
        root = np.sqrt(x.clip(min=0.0))
        return np.asarray(-(root**3) - _DAMPINGS * root * v)

    first = rate(depth, speed)
    second = rate(depth + _STEP / 2 * speed, speed + _STEP / 2 * first)
    third_speed = speed + _STEP / 2 * second
    third = rate(depth + _STEP / 2 * (speed + _STEP / 2 * first), third_speed)
    last_speed = speed + _STEP * third
    fourth = rate(depth + _STEP * third_speed, last_speed)
    mean = (speed + 2 * (speed + _STEP / 2 * first) + 2 * third_speed + last_speed) / 6
    return depth + _STEP * mean, speed + _STEP * (first + 2 * second + 2 * third + fourth) / 6


@cache
def _inverse() -> tuple[Floats, Floats]:
    """Return e rising and the damping that gives it."""
    return _table()[::-1].copy(), _DAMPINGS[::-1].copy()


@cache
def _slopes() -> Floats:
    """Return the slope a of a contact that loses by viscosity alone, by damping."""
    fall = -np.gradient(np.log(_table()), _DAMPINGS) * _DAMPINGS
    fall[0] = fall[1]
    return np.asarray(0.2 * REFERENCE_SPEED**-0.2 * fall)


EFFECT = ContactEffect(
    name="restitution-viscoelastic",
    title="Viscoelastic restitution",
    parameters=(
        Parameter(
            symbol="a",
            unit="(m/s)^-0.2",
            meaning="loss of e for each unit of (v^0.2 - v0^0.2) / 0.2 about v0 = 2 m/s",
            plausible=(0.0, 0.08),
        ),
    ),
    formula="e = e0 [1 - a (v_n^0.2 - v0^0.2) / 0.2 + ...], e0 E(gamma)/E(gamma0) as a whole",
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
