"""Structure that is left when the model has done what it can: the omnibus alarm and the heat map.

A cell is a channel (what is disturbed) against a covariate (what it may depend on), as five smooth
functions of that covariate. Each shot's own numbers and everything fitted are projected out, so a
cell's chi-squared has its stated degrees of freedom when nothing is missing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.stats import chi2 as chi2_distribution

from analysis.model.channels import contact_columns, frame_channels
from analysis.model.covariates import shot_covariates
from analysis.model.fit import Fit, fit_campaign
from analysis.model.noise import rescaled
from analysis.model.projector import Projector, Solved, projector
from analysis.model.tables import Data

Floats = NDArray[np.float64]

SMOOTH = 5


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell of the heat map.

    Attributes
    ----------
    channel, covariate
        What is disturbed, and against what.
    chi2, freedom
        Fall of chi-squared that five smooth functions would bring, in units of the noise found.
    p_value
        By itself; `p_holm` with all cells looked at.
    carried_share
        Share of the fall that is gone without the two shots that speak loudest for it.
    """

    channel: str
    covariate: str
    chi2: float
    freedom: int
    p_value: float
    p_holm: float
    carried_share: float


def lack_of_fit(data: Data, fit: Fit) -> tuple[Cell, ...]:
    """Test every cell; the most striking first.

    The noise of positions and that of orientations are taken as large as the residuals say, each
    by itself: one scale for both, where the stated ones are wrong in different ways, alarms.
    """
    data, fit = noise_matched(data, fit)
    return cells_of(data, fit, projector(data, fit))


def noise_matched(data: Data, fit: Fit) -> tuple[Data, Fit]:
    """Return the data with sigmas as large as the residuals say, and their fit."""
    data = rescaled(data, fit)
    return data, fit_campaign(data, fit.theory, fit)


def cells_of(data: Data, fit: Fit, sums: Projector) -> tuple[Cell, ...]:
    """Test every cell of a fit whose sigmas are true; the most striking first."""
    covariates = shot_covariates(data, fit)
    scale2 = max(fit.chi2_per_dof, 1e-12)
    found: list[tuple[str, str, Solved]] = []
    for name, columns in contact_columns(data, fit).items():
        by_shot = sums.project(columns)
        for covariate, values in covariates.items():
            found.append((name, covariate, sums.solve(by_shot, _basis(values))))
    whole = np.ones((len(data.shots), 1))
    for channel in frame_channels(data, fit):
        by_shot = sums.project(channel.columns())
        found.append((channel.name, channel.covariate, sums.solve(by_shot, whole)))
    p_values = np.array([_chance(solved, scale2) for *_, solved in found])
    cells = [
        Cell(channel, covariate, s.chi2 / scale2, s.freedom, float(p), float(q), s.carried_share)
        for (channel, covariate, s), p, q in zip(found, p_values, holm(p_values), strict=True)
    ]
    return tuple(sorted(cells, key=lambda cell: (cell.p_value, -cell.chi2)))


def _chance(solved: Solved, scale2: float) -> float:
    if solved.freedom == 0:
        return 1.0
    return float(chi2_distribution.sf(solved.chi2 / scale2, solved.freedom))


def _basis(values: Floats) -> Floats:
    """Return five Chebyshev polynomials of a covariate on its 1 to 99 per cent range, (S, 5)."""
    low, high = np.quantile(values, [0.01, 0.99])
    if high - low < 1e-12:
        return np.ones((len(values), 1))
    scaled = np.clip(2 * (values - low) / (high - low) - 1, -1, 1)
    return np.asarray(chebyshev.chebvander(scaled, SMOOTH - 1))


def holm(p_values: Floats) -> Floats:
    """Return p-values with all of them looked at, shape (K,), never above 1.

    S. Holm, Scand. J. Statist. 6, 65 (1979).
    """
    order = np.argsort(p_values)
    factors = len(p_values) - np.arange(len(p_values))
    adjusted = np.minimum(np.maximum.accumulate(p_values[order] * factors), 1.0)
    result = np.empty_like(adjusted)
    result[order] = adjusted
    return result
