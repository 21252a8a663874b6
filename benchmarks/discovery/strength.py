"""How strong a hidden effect is, in units of what a campaign of the same shots can see."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.inside import without_contact_frames
from analysis.model.fitting.fit import fit_campaign
from benchmarks.discovery.campaigns import SILENCE, campaign
from simulators.challenge.effects import HIDDEN

MOST_TIMES = 8
PASSES = 3
"""Enough for effects that are not quite linear."""
WITHIN = 0.8
"""Of the believed range: an effect near its end is measured beyond it every other time."""


def strength(amplitudes: Mapping[str, float], seed: int, shots: int) -> float:
    """Return d: the root of the chi-squared that the base model leaves without noise."""
    silent = without_contact_frames(campaign(amplitudes, seed, shots, noise=SILENCE))
    return float(np.sqrt(fit_campaign(silent).chi2))


def believable_shots(name: str, d: float, seed: int, shots: int) -> int:
    """Return how many shots, these at least, show an effect at d while it is in its believed range.

    An effect beyond its range is in no verdict. Where the catalogue's effect has other parameters
    than the hidden one's amplitude, the shots are as they were given.
    """
    effect = next(one for one in CATALOGUE if one.name == name)
    if len(effect.parameters) > 1 or effect.parameters[0].unit != HIDDEN[name].unit:
        return shots
    amplitude = amplitude_at(name, d, seed, shots)
    least, largest = effect.parameters[0].plausible
    limit = WITHIN * (largest if amplitude > 0 else -least)
    times = (amplitude / limit) ** 2 if limit > 0 else 1.0
    return int(np.ceil(shots * np.clip(times, 1.0, MOST_TIMES)))


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
