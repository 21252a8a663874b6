"""Restitution and friction of each contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulators.challenge.launch import Settings, Touch
from simulators.challenge.nature import Nature
from simulators.challenge.viscoelastic import REFERENCE_SPEED_M_PER_S, softening

Floats = NDArray[np.float64]

_MOST_OBLIQUE = 3.0
_SLOWEST_SLIP_M_PER_S = 0.01
_USUAL_TEMPERATURE_C = 23.0
_SLIP_OF_MU_M_PER_S = 1.0
"""Slip speed at which a friction that follows it is the stated one: a change per factor of e is one
of mu there."""


@dataclass(frozen=True, slots=True, eq=False)
class Coefficients:
    """e, mu and beta0 of S contacts, each (S,)."""

    restitution: Floats
    friction: Floats
    rolling_restitution: Floats


def coefficients(nature: Nature, settings: Settings, touch: Touch, radius_m: float) -> Coefficients:
    """Return what holds in each contact, from how the spheres meet and when."""
    approach = touch.approach
    slip = np.maximum(np.linalg.norm(touch.slip(radius_m), axis=1), _SLOWEST_SLIP_M_PER_S)
    restitution = nature.restitution * softening(approach, nature.restitution, nature.viscosity)
    restitution *= (approach / REFERENCE_SPEED_M_PER_S) ** -nature.restitution_power
    obliquity = np.minimum(slip / approach, _MOST_OBLIQUE)
    restitution *= 1.0 + nature.restitution_obliquity * obliquity
    restitution *= 1.0 + nature.restitution_drift * settings.order
    warmth = settings.temperature_c - _USUAL_TEMPERATURE_C
    restitution *= 1.0 + nature.restitution_per_kelvin * warmth
    friction = nature.friction * (1.0 + nature.friction_drift * settings.order)
    friction *= 1.0 + nature.friction_speed * np.log(slip / _SLIP_OF_MU_M_PER_S)
    rolling = np.full_like(restitution, nature.rolling_restitution)
    if nature.dependence is not None:
        restitution *= nature.dependence.factor("e", settings, touch, radius_m)
        friction *= nature.dependence.factor("mu", settings, touch, radius_m)
    return Coefficients(restitution, friction, rolling)
