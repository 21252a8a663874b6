"""Laws of other slots, arguments and shapes than tests hide, at one strength.

In hard spheres and in contacts that last, there with the amplitude that hard spheres need.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.inside import without_contact_frames
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from benchmarks.discovery.campaigns import SILENCE, STATED, posed
from benchmarks.discovery.lasting import PLAIN, lasting_campaign
from simulators.challenge.campaign import Noise, run_campaign
from simulators.challenge.launch import Settings, Touch
from simulators.challenge.nature import Nature
from simulators.challenge.unnamed import Dependence, Law

Floats = NDArray[np.float64]

FIRST_GUESS = 0.01
"""Amplitude from which the one of a strength is found."""


def _slip(touch: Touch, radius_m: float) -> Floats:
    return np.asarray(np.linalg.norm(touch.slip(radius_m), axis=1))


def _whirl(touch: Touch) -> Floats:
    return np.asarray(np.einsum("si,si->s", touch.spin[:, 1] - touch.spin[:, 0], touch.normal))


def _slow_slip(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.exp(-_slip(touch, radius_m) / 1.5)


def _fast(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.where(touch.approach > 4.5, 1.0, 0.0)


def _one_warmth(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.exp(-0.5 * ((settings.temperature_c - 24.0) / 0.7) ** 2)


def _worn(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.maximum(settings.order - 0.1, 0.0)


def _striped(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.sin(2 * np.pi * touch.point[:, 0] / 2.5e-3)


def _near_the_camera(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return touch.point[:, 2] * 1e3


def _whirling(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.tanh((_whirl(touch) / 120.0) ** 2)


LAWS: Mapping[str, Law] = MappingProxyType(
    {
        name: Law(slot, argument, shape, size, "1", name, FIRST_GUESS)
        for name, slot, argument, shape, size in (
            ("e-slow-slip", "e", "speed_s", "exponential", _slow_slip),
            ("mu-fast", "mu", "speed_n", "step", _fast),
            ("mu-one-warmth", "mu", "temperature_c", "bump", _one_warmth),
            ("mu-worn", "mu", "order", "hinge", _worn),
            ("e-striped", "e", "contact_x", "periodic", _striped),
            ("mu-near-the-camera", "mu", "contact_z", "linear", _near_the_camera),
            ("e-whirling", "e", "spin", "power", _whirling),
        )
    }
)
"""By name."""


def drawn_at(law: Law, d: float, seed: int, shots: int, *, lasting: bool) -> PoseData:
    """Return a campaign that hides a law at a strength."""

    def nature(of: Nature, amplitude: float) -> Nature:
        return replace(of, dependence=Dependence(law, amplitude))

    def campaign(amplitude: float, noise: Noise) -> PoseData:
        hidden = nature(Nature(), amplitude)
        return posed(run_campaign(hidden, seed, shots=shots, noise=noise))

    silent = without_contact_frames(campaign(FIRST_GUESS, SILENCE))
    amplitude = FIRST_GUESS * d / float(np.sqrt(fit_campaign(silent).chi2))
    if lasting:
        return lasting_campaign(nature(PLAIN, amplitude), seed, shots)
    return campaign(amplitude, STATED)
