"""A fit seen to first order, with everything that was fitted projected out.

Each shot's own numbers are eliminated shot by shot (Schur complement), then what all shots share:
what is left of any column is what no fitted number can imitate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.model.fit import Fit
from analysis.model.linear import linearise
from analysis.model.normal import BETA0_PRIOR_SIGMA, inverse, solve_blocks
from analysis.model.poses import PoseData

Floats = NDArray[np.float64]

LEAST_EIGENVALUE = 1e-3
"""Below this share a direction is only the rounding of differences."""
LEAST_INFORMATION = 1e-6
"""A column of which less is left is what a fitted number does already."""


@dataclass(frozen=True, slots=True, eq=False)
class ByShot:
    """What some columns add up to in each shot, its own numbers eliminated.

    own (S, C, C), against (S, C, P) with the fitted parameters, gradient (S, C); raw (S, C) is what
    the squares were before anything was eliminated.
    """

    own: Floats
    against: Floats
    gradient: Floats
    raw: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """Amplitudes of C columns times K functions, shape (K C,), and their covariance.

    Both are zero along what cannot be seen; chi2 is the fall that they bring, freedom the number of
    directions that are seen.
    """

    amplitudes: Floats
    covariance: Floats
    chi2: float
    freedom: int


@dataclass(frozen=True, slots=True, eq=False)
class Projector:
    """A linearised fit: S shots, N whitened numbers a shot, P shared parameters.

    Attributes
    ----------
    residual
        Whitened residuals of the fit, shape (S, N).
    by_state
        Whitened derivatives by each shot's own numbers, shape (S, N, 24).
    states
        Their information, shape (S, 24, 24).
    shared
        Derivatives by the shared parameters less what the shot's own numbers can imitate, shape
        (S, N, P).
    covariance
        Of the shared parameters, shape (P, P).
    """

    residual: Floats
    by_state: Floats
    states: Floats
    shared: Floats
    covariance: Floats

    def project(self, columns: Floats) -> ByShot:
        """Eliminate each shot's own numbers from columns (S, N, C)."""
        transposed = np.swapaxes(columns, 1, 2)
        coupling = np.swapaxes(self.by_state, 1, 2) @ columns
        eliminated = np.swapaxes(solve_blocks(self.states, coupling), 1, 2)
        own_gradient = np.swapaxes(self.by_state, 1, 2) @ self.residual[..., None]
        gradient = transposed @ self.residual[..., None] - eliminated @ own_gradient
        return ByShot(
            own=transposed @ columns - eliminated @ coupling,
            against=transposed @ self.shared,
            gradient=gradient[..., 0],
            raw=(columns**2).sum(axis=1),
        )

    def summed(self, channel: ByShot, basis: Floats) -> tuple[Floats, Floats]:
        """Return M and g of columns times a basis (S, K) over the shots, all that is fitted out.

        Shapes (K C, K C) and (K C,).
        """
        count = basis.shape[1] * channel.own.shape[1]
        own = np.einsum("sk,sl,sij->kilj", basis, basis, channel.own).reshape(count, count)
        against = np.einsum("sk,sip->kip", basis, channel.against).reshape(count, -1)
        gradient = np.einsum("sk,si->ki", basis, channel.gradient).ravel()
        return own - against @ self.covariance @ against.T, gradient

    def solve(self, channel: ByShot, basis: Floats) -> Solved:
        """Fit amplitudes of columns times a basis (S, K) beside all that was fitted."""
        matrix, gradient = self.summed(channel, basis)
        before = np.einsum("sk,sii->ki", basis**2, channel.own).ravel()
        raw = np.einsum("sk,si->ki", basis**2, channel.raw).ravel()
        shown = np.flatnonzero(np.diag(matrix) > LEAST_INFORMATION * raw)
        root = np.sqrt(before[shown])
        scaled = matrix[np.ix_(shown, shown)] / root[:, None] / root[None, :]
        values, vectors = np.linalg.eigh(scaled)
        seen = values > LEAST_EIGENVALUE
        along = np.zeros((len(raw), int(seen.sum())))
        along[shown] = vectors[:, seen] / root[:, None]
        covariance = (along / values[seen]) @ along.T
        amplitudes = covariance @ gradient
        return Solved(amplitudes, covariance, float(gradient @ amplitudes), int(seen.sum()))


def projector(data: PoseData, fit: Fit) -> Projector:
    """Linearise about a fit and project."""
    line = linearise(data, fit.states, fit.theory)
    by_state = np.swapaxes(line.by_state, 1, 2)
    states = by_state @ line.by_state
    shared = line.by_theory - line.by_state @ solve_blocks(states, by_state @ line.by_theory)
    information = np.einsum("snp,snq->pq", shared, shared)
    information[2, 2] += BETA0_PRIOR_SIGMA**-2
    return Projector(line.residual, line.by_state, states, shared, inverse(information))
