"""Products of two arguments at one strength, by how much either argument holds by itself.

With the zero of one argument k standard deviations of the shots from their mean, the other alone
holds k^2 / (1 + k^2) of the product over the shots: 0, 0.5, 0.8 and 0.9 for k = 0, 1, 2, 3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.inside import without_contact_frames
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from benchmarks.discovery.campaigns import SILENCE, STATED, posed
from simulators.challenge.campaign import Noise, run_campaign
from simulators.challenge.launch import Settings, Touch
from simulators.challenge.nature import Nature
from simulators.challenge.unnamed import Dependence, Law

Floats = NDArray[np.float64]
Of = Callable[[Settings, Touch, float], Floats]

WAYS_OFF = (0, 1, 2, 3)
"""Of a zero from the mean of the shots, in their standard deviations."""
FIRST_GUESS = 0.01
"""Amplitude from which the one of a strength is found, for arguments of unit spread."""


@dataclass(frozen=True, slots=True)
class Pair:
    """A coefficient and two arguments; the zero of the first is the one that lies off."""

    slot: str
    argument: str
    first: Of
    second: Of


def _ln_approach(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.log(touch.approach)


def _ln_slip(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return np.log(np.maximum(np.linalg.norm(touch.slip(radius_m), axis=1), 0.01))


def _warmth(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return settings.temperature_c


def _order(settings: Settings, touch: Touch, radius_m: float) -> Floats:
    return settings.order


PAIRS = (
    Pair("e", "speed_n*temperature_c", _ln_approach, _warmth),
    Pair("mu", "speed_s*temperature_c", _ln_slip, _warmth),
    Pair("e", "order*speed_n", _order, _ln_approach),
)
"""One of them for each seed in turn."""


def product_at(d: float, off: int, seed: int, shots: int) -> tuple[PoseData, Pair]:
    """Return a campaign that hides a product at a strength, its zero so far off, and which."""
    pair = PAIRS[seed % len(PAIRS)]

    def size(settings: Settings, touch: Touch, radius_m: float) -> Floats:
        first, second = (
            _standard(of(settings, touch, radius_m)) for of in (pair.first, pair.second)
        )
        return (first + off) * second

    def campaign(amplitude: float, noise: Noise) -> PoseData:
        law = Law(pair.slot, pair.argument, "linear", size, "1", "a product", amplitude)
        nature = Nature(dependence=Dependence(law, amplitude))
        return posed(run_campaign(nature, seed, shots=shots, noise=noise))

    silent = without_contact_frames(campaign(FIRST_GUESS, SILENCE))
    found = float(np.sqrt(fit_campaign(silent).chi2))
    return campaign(FIRST_GUESS * d / found, STATED), pair


def _standard(values: Floats) -> Floats:
    return (values - values.mean()) / values.std()
