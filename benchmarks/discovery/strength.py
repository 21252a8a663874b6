"""How strong a hidden effect is, in units of what a campaign of the same shots can see."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from analysis.model.fit import fit_campaign
from analysis.model.inside import without_contact_frames
from benchmarks.discovery.campaigns import SILENCE, campaign
from simulators.challenge.effects import HIDDEN

PASSES = 3
"""Enough for effects that are not quite linear."""


def strength(amplitudes: Mapping[str, float], seed: int, shots: int) -> float:
    """Return d: the root of the chi-squared that the base model leaves without noise."""
    silent = without_contact_frames(campaign(amplitudes, seed, shots, noise=SILENCE))
    return float(np.sqrt(fit_campaign(silent).chi2))


def amplitude_at(name: str, d: float, seed: int, shots: int) -> float:
    """Return how large an effect must be to have this d in a campaign of this seed."""
    hidden = HIDDEN[name]
    sign = -1.0 if hidden.either_sign and seed % 2 else 1.0
    amplitude = sign * hidden.amplitude * 0.1
    for _ in range(PASSES):
        found = strength({name: amplitude}, seed, shots)
        amplitude *= d / found
        if abs(found - d) < 0.02 * d:
            break
    return amplitude
