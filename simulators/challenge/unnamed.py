"""Laws of the contact that no catalogue holds: a coefficient that follows one thing of a shot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from simulators.challenge.launch import Settings, Touch

Floats = NDArray[np.float64]

_SLOWEST_M_PER_S = 0.01
_USUAL_TEMPERATURE_C = 23.0
_REFERENCE_M_PER_S = 2.0
_USUAL_APPROACH_M_PER_S = 5.0
_GRAIN_RAD = 0.5


@dataclass(frozen=True, slots=True)
class Law:
    """One coefficient as a function of one thing, or of the product of two.

    Parameters
    ----------
    slot, argument, shape
        What depends on what, and how, as an answer would say it.
    size
        From settings, touch and the sphere's radius, m, to how much of the amplitude acts, (S,).
    unit, meaning
        Of the amplitude.
    amplitude
        At full strength.
    """

    slot: str
    argument: str
    shape: str
    size: Callable[[Settings, Touch, float], Floats]
    unit: str
    meaning: str
    amplitude: float


@dataclass(frozen=True, slots=True)
class Dependence:
    """A law at some amplitude."""

    law: Law
    amplitude: float

    def factor(self, slot: str, settings: Settings, touch: Touch, radius_m: float) -> Floats:
        """Return by what a coefficient of the plain theory is multiplied, (S,)."""
        if slot != self.law.slot:
            return np.ones(len(settings.offset_mm))
        return 1.0 + self.amplitude * self.law.size(settings, touch, radius_m)


def _slip(touch: Touch, radius_m: float) -> Floats:
    return np.asarray(np.maximum(np.linalg.norm(touch.slip(radius_m), axis=1), _SLOWEST_M_PER_S))


def _warmth(settings: Settings) -> Floats:
    return np.asarray(settings.temperature_c - _USUAL_TEMPERATURE_C)


def _whirl(touch: Touch) -> Floats:
    """Return the relative spin about the normal, rad/s, without its sign, (S,)."""
    relative = np.einsum("si,si->s", touch.spin[:, 1] - touch.spin[:, 0], touch.normal)
    return np.asarray(np.abs(relative))


def _bump(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.asarray(np.exp(-0.5 * ((touch.approach - 5.0) / 0.6) ** 2))


def _slowing(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.asarray(np.exp(-_slip(touch, radius_m) / 2.5))


def _spinning(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.asarray(radius_m * _whirl(touch) / _REFERENCE_M_PER_S)


def _grain(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    angle = np.arctan2(touch.normal[:, 0], touch.normal[:, 1])
    return np.asarray(np.cos(2.0 * (angle - _GRAIN_RAD)))


def _step(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.where(settings.order > 0.1, 1.0, 0.0)


def _warm(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return _warmth(settings)


def _warm_and_fast(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.asarray(_warmth(settings) * np.log(touch.approach / _USUAL_APPROACH_M_PER_S))


def _knee(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.maximum(touch.point[:, 1] * 1e3 - 0.5, 0.0)


LAWS: Mapping[str, Law] = MappingProxyType(
    {
        "restitution-bump": Law(
            "e", "speed_n", "bump", _bump, "1", "relative rise of e about 5 m/s", 0.02
        ),
        "restitution-grain": Law(
            "e",
            "normal",
            "periodic",
            _grain,
            "1",
            "relative change of e with twice the angle of the normal from 0.5 rad",
            0.02,
        ),
        "restitution-step": Law(
            "e", "order", "step", _step, "1", "relative change of e at 0.6 of the campaign", 0.02
        ),
        "restitution-warm-and-fast": Law(
            "e",
            "speed_n*temperature_c",
            "linear",
            _warm_and_fast,
            "1/K",
            "relative change of e for each kelvin and each factor of e in speed",
            0.006,
        ),
        "restitution-knee": Law(
            "e",
            "contact_y",
            "hinge",
            _knee,
            "1/mm",
            "relative change of e for each mm beyond 0.5 mm to the right",
            0.01,
        ),
        "friction-exponential": Law(
            "mu", "speed_s", "exponential", _slowing, "1", "relative rise of mu at no slip", 0.5
        ),
        "friction-spin": Law(
            "mu",
            "spin",
            "linear",
            _spinning,
            "1",
            "relative change of mu for 2 m/s of spin about the normal",
            0.2,
        ),
        "friction-temperature": Law(
            "mu", "temperature_c", "linear", _warm, "1/K", "relative change of mu", 0.06
        ),
    }
)
"""By name."""
