"""How large the noise really is, positions and orientations apart.

Taken from the scatter about each sphere's two free flights, fitted side by side without any law of
contact: what is missing in the law does not make the noise look larger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.model.comparison import KINDS, Comparison, compare
from analysis.model.fit import Fit
from analysis.model.poses import PoseData

Floats = NDArray[np.float64]

_POSITION = (0, 2)
"""Blocks of positions among the kinds; the others are orientations."""
_LEAST = 1e-12


@dataclass(frozen=True, slots=True)
class NoiseScale:
    """By what to multiply stated sigmas of one kind, and the standard error of that factor."""

    value: float
    sigma: float


def noise_scales(data: PoseData, fit: Fit) -> tuple[NoiseScale, NoiseScale]:
    """Return by what to multiply the stated sigmas of positions and of orientations.

    1 with an infinite error where nothing is left over to tell.
    """
    line, _ = compare(data, fit.states, fit.theory)
    squares, freedom = free_flight_misfit(line)
    scales = []
    for kinds in (_POSITION, tuple(set(range(KINDS)) - set(_POSITION))):
        chi2, count = squares[:, kinds].sum(), freedom[:, kinds].sum()
        if count > 0:
            value = float(np.sqrt(chi2 / count))
            scales.append(NoiseScale(value, value / float(np.sqrt(2 * count))))
        else:
            scales.append(NoiseScale(1.0, np.inf))
    return scales[0], scales[1]


def free_flight_misfit(line: Comparison) -> tuple[Floats, Floats]:
    """Return chi-squared about the free flights and its degrees of freedom, by block, (S, 4)."""
    pulled = np.swapaxes(line.slopes, 2, 3) @ line.residual[..., None]
    scale = np.sqrt(np.maximum(np.diagonal(line.gram, axis1=2, axis2=3), _LEAST))
    scaled = line.gram / scale[..., :, None] / scale[..., None, :]
    values, vectors = np.linalg.eigh(scaled)
    along = (np.swapaxes(vectors, 2, 3) @ (pulled / scale[..., None]))[..., 0]
    seen = values > _LEAST
    explained = np.where(seen, along**2 / np.where(seen, values, 1.0), 0.0).sum(axis=2)
    measured = (np.abs(line.slopes).sum(axis=3) > 0).sum(axis=2)
    return (line.residual**2).sum(axis=2) - explained, measured - seen.sum(axis=2)


def rescaled(data: PoseData, fit: Fit) -> PoseData:
    """Return the data with sigmas as large as the scatter about free flight says they are."""
    position, rotation = noise_scales(data, fit)
    return data.with_sigmas(
        position.value * data.position_sigma, rotation.value * data.rotation_sigma
    )
