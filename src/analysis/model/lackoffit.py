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

from analysis.model.channels import camera_columns, contact_columns, flight_columns
from analysis.model.covariates import shot_covariates
from analysis.model.fit import Fit, fit_campaign
from analysis.model.linear import linearise
from analysis.model.noise import rescaled
from analysis.model.normal import BETA0_PRIOR_SIGMA, inverse, solve_blocks
from analysis.model.poses import PoseData

Floats = NDArray[np.float64]

SMOOTH = 5
LEAST_EIGENVALUE = 1e-3
"""Below this share a direction is only the rounding of differences."""


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
        By itself; `p_holm` with all cells looked at (S. Holm, Scand. J. Statist. 6, 65 (1979)).
    """

    channel: str
    covariate: str
    chi2: float
    freedom: int
    p_value: float
    p_holm: float


def lack_of_fit(data: PoseData, fit: Fit) -> tuple[Cell, ...]:
    """Test every cell; the most striking first.

    The noise of positions and that of orientations are taken as large as the residuals say, each
    by itself: one scale for both, where the stated ones are wrong in different ways, alarms.
    """
    data = rescaled(data, fit)
    fit = fit_campaign(data, fit.theory, fit)
    sums = _Projector(data, fit)
    found: list[tuple[str, str, float, int]] = []
    for name, columns in contact_columns(data, fit).items():
        by_shot = sums.project(columns)
        for covariate, values in shot_covariates(data, fit).items():
            found.append((name, covariate, *sums.test(by_shot, _basis(values))))
    for name, covariate, columns in (*flight_columns(data, fit), *camera_columns(data, fit)):
        by_shot = sums.project(columns)
        found.append((name, covariate, *sums.test(by_shot, np.ones((len(data.shots), 1)))))
    p_values = np.array([chi2_distribution.sf(c, max(k, 1)) if k else 1.0 for *_, c, k in found])
    holm = _holm(p_values)
    cells = [
        Cell(channel, covariate, float(c), k, float(p), float(q))
        for (channel, covariate, c, k), p, q in zip(found, p_values, holm, strict=True)
    ]
    return tuple(sorted(cells, key=lambda cell: cell.p_value))


def _basis(values: Floats) -> Floats:
    """Return five Chebyshev polynomials of a covariate on its 1 to 99 per cent range, (S, 5)."""
    low, high = np.quantile(values, [0.01, 0.99])
    if high - low < 1e-12:
        return np.ones((len(values), 1))
    scaled = np.clip(2 * (values - low) / (high - low) - 1, -1, 1)
    return np.asarray(chebyshev.chebvander(scaled, SMOOTH - 1))


def _holm(p_values: Floats) -> Floats:
    order = np.argsort(p_values)
    factors = len(p_values) - np.arange(len(p_values))
    adjusted = np.minimum(np.maximum.accumulate(p_values[order] * factors), 1.0)
    result = np.empty_like(adjusted)
    result[order] = adjusted
    return result


@dataclass(frozen=True, slots=True, eq=False)
class _ByShot:
    """What a channel's columns add up to in each shot, its own numbers eliminated.

    own (S, C, C), against (S, C, P) with the fitted parameters, gradient (S, C).
    """

    own: Floats
    against: Floats
    gradient: Floats


class _Projector:
    """Holds what every cell shares: the linearised fit and its projections."""

    def __init__(self, data: PoseData, fit: Fit) -> None:
        line = linearise(data, fit.states, fit.theory)
        self._residual, self._by_theory = line.residual, line.by_theory
        self._by_state = np.swapaxes(line.by_state, 1, 2)
        self._states = self._by_state @ line.by_state
        self._coupling = self._by_state @ line.by_theory
        self._own_gradient = self._by_state @ line.residual[..., None]
        eliminated = solve_blocks(self._states, self._coupling)
        by_theory = np.swapaxes(line.by_theory, 1, 2)
        inner = by_theory @ line.by_theory - np.swapaxes(self._coupling, 1, 2) @ eliminated
        self._fitted = inner.sum(axis=0)
        self._fitted[2, 2] += BETA0_PRIOR_SIGMA**-2
        self._scale2 = max(fit.chi2_per_dof, 1e-12)

    def project(self, columns: Floats) -> _ByShot:
        """Eliminate each shot's own numbers from a channel's columns (S, N, C)."""
        transposed = np.swapaxes(columns, 1, 2)
        coupling = self._by_state @ columns
        eliminated = np.swapaxes(solve_blocks(self._states, coupling), 1, 2)
        return _ByShot(
            own=transposed @ columns - eliminated @ coupling,
            against=transposed @ self._by_theory - eliminated @ self._coupling,
            gradient=(transposed @ self._residual[..., None] - eliminated @ self._own_gradient)[
                ..., 0
            ],
        )

    def test(self, channel: _ByShot, basis: Floats) -> tuple[float, int]:
        """Return chi-squared and degrees of freedom of a channel with a basis (S, K) over shots."""
        count = basis.shape[1] * channel.own.shape[1]
        own = np.einsum("sk,sl,sij->kilj", basis, basis, channel.own).reshape(count, count)
        against = np.einsum("sk,sip->kip", basis, channel.against).reshape(count, -1)
        gradient = np.einsum("sk,si->ki", basis, channel.gradient).ravel()
        raw = np.maximum(np.diag(own), 1e-300)
        own = own - against @ inverse(self._fitted) @ against.T
        scaled = own / np.sqrt(raw[:, None] * raw[None, :])
        values, vectors = np.linalg.eigh(scaled)
        seen = values > LEAST_EIGENVALUE
        along = vectors[:, seen].T @ (gradient / np.sqrt(raw))
        return float((along**2 / values[seen]).sum() / self._scale2), int(seen.sum())
