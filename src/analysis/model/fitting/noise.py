"""How large the noise really is, positions and orientations apart.

Taken from the scatter about each sphere's two free flights, fitted side by side without any law of
contact: what is missing in the law does not make the noise look larger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.fit import Fit, parts_of
from analysis.model.fitting.nuisance import MOST_PULL
from analysis.model.loops import plain
from analysis.model.loops.blocks import whitenings
from analysis.model.predict.comparison import Comparison, compare, weights

_LEAST = 1e-12


@dataclass(frozen=True, slots=True)
class NoiseScale:
    """By what to multiply stated sigmas of one kind, and the standard error of that factor.

    Attributes
    ----------
    by_slow
        What slow errors of the stated size make of it at most: what of them changes within a
        flight scatters beside the stated sigmas.
    """

    value: float
    sigma: float
    by_slow: float = 1.0


UNTOLD = NoiseScale(1.0, np.inf)


def noise_scales(data: CampaignData, fit: Fit) -> tuple[NoiseScale, NoiseScale]:
    """Return by what to multiply the stated sigmas of positions and of orientations.

    1 with an infinite error where nothing is left over to tell, as in a table of contacts. Air that
    a wrong law pulls far from what is stated is left as stated: flights would scatter about it.
    """
    if isinstance(data, ContactTable):
        return UNTOLD, UNTOLD
    squares, freedom, slow = np.zeros((3, 2))
    theory = fit.theory.unstrained(MOST_PULL)
    for part, states in parts_of(data, fit):
        line, _ = compare(part, states, theory)
        left, free = free_flight_misfit(line)
        squares += left
        freedom += free
        slow += _slow_squares(part)
    kinds = zip(squares, freedom, slow, strict=True)
    position, rotation = (_scale(*map(float, of_kind)) for of_kind in kinds)
    return position, rotation


@dataclass(frozen=True, slots=True, eq=False)
class FreeFlight:
    """Residuals about two free flights of each sphere, whatever the law between them.

    Attributes
    ----------
    left
        Whitened residuals with the flights fitted, shape (S, B, L).
    basis
        What fitting them took, unit columns across each other, shape (S, B, L, 48 / B).
    change
        By what that changed the numbers of each sphere and kind, place and rate of either side,
        shape (S, B, 48 / B).
    share
        One less the leverage of each residual, zero where nothing was measured, shape (S, B, L):
        they add up to the degrees of freedom.
    """

    left: Floats
    basis: Floats
    change: Floats
    share: Floats


def about_free_flight(line: Comparison, bent: Floats | None = None) -> FreeFlight:
    """Fit the numbers of both flights of each sphere, and nothing else.

    Parameters
    ----------
    bent
        What else may bend them, whitened, shape (S, B, L, K); it stands behind the flights' own
        numbers in all that is returned.
    """
    columns, gram = line.slopes, line.gram
    if bent is not None and bent.shape[3]:
        columns = np.concatenate([columns, bent], axis=3)
        gram = np.swapaxes(columns, 2, 3) @ columns
    units = whitenings(plain(gram), _LEAST)
    basis = columns @ units
    taken = np.swapaxes(basis, 2, 3) @ line.residual[..., None]
    measured = line.slopes.any(axis=3)
    return FreeFlight(
        left=line.residual - (basis @ taken)[..., 0],
        basis=basis,
        change=(units @ taken)[..., 0],
        share=np.where(measured, 1 - np.einsum("sblp,sblp->sbl", basis, basis), 0.0),
    )


def free_flight_misfit(line: Comparison) -> tuple[Floats, Floats]:
    """Return chi-squared about free flight and its freedom, each (positions, orientations)."""
    flight = about_free_flight(line)
    kinds = (~line.orientations, line.orientations)
    return (
        np.array([(flight.left**2)[:, kind].sum() for kind in kinds]),
        np.array([flight.share[:, kind].sum() for kind in kinds]),
    )


def rescaled(data: CampaignData, fit: Fit) -> CampaignData:
    """Return the data with sigmas as large as the scatter about free flight says they are."""
    if isinstance(data, ContactTable):
        return data
    position, rotation = noise_scales(data, fit)
    return data.with_noise(position.value, rotation.value)


def _slow_squares(part: Data) -> Floats:
    """Return squares of slow errors over sigma, summed over what was measured: (places, turns)."""
    if isinstance(part, ContactTable):
        return np.zeros(2)
    squares = (weights(part) ** 2).sum(axis=(0, 1, 2))
    return np.asarray((np.array(part.slow.sizes) ** 2 * squares.reshape(2, 3)).sum(axis=1))


def _scale(chi2: float, freedom: float, slow: float) -> NoiseScale:
    if freedom < 0.5:
        return UNTOLD
    value = float(np.sqrt(chi2 / freedom))
    return NoiseScale(
        value, value / float(np.sqrt(2 * freedom)), float(np.sqrt(1 + slow / freedom))
    )
