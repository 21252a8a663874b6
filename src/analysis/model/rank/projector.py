"""A fit seen to first order, with everything that was fitted projected out.

Each shot's own numbers are eliminated shot by shot (Schur complement), then what all shots share:
what is left of any column is what no fitted number can imitate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.normal import inverse, solve_blocks, with_prior
from analysis.model.fitting.shared_noise import SharedNoise
from analysis.model.predict.linear import linearise

Floats = NDArray[np.float64]

CARRIERS = 2
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
    directions that are seen. `carried_share` of the fall is gone without its two loudest shots.
    """

    amplitudes: Floats
    covariance: Floats
    chi2: float
    freedom: int
    carried_share: float


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
    own_gradient
        Downhill by the shot's own numbers, shape (S, 24).
    noise
        Noise that frames or numbers share, where the data have such.
    shared
        Derivatives by the shared parameters less what the shot's own numbers can imitate, shape
        (S, N, P).
    covariance
        Of the shared parameters, shape (P, P).
    held
        Of `Theory.held`, shapes (P,).
    left
        Downhill by the shared parameters, the prior in, shape (P,): little, for a fit ends before
        its very minimum. A direction that they nearly imitate would show all of it.
    """

    residual: Floats
    by_state: Floats
    states: Floats
    own_gradient: Floats
    shared: Floats
    covariance: Floats
    held: tuple[Floats, Floats]
    left: Floats
    noise: SharedNoise | None = None

    def project(self, columns: Floats) -> ByShot:
        """Eliminate each shot's own numbers from columns (S, N, C)."""
        if self.noise is not None:
            columns = self.noise.whiten_frames(columns)
        transposed = np.swapaxes(columns, 1, 2)
        coupling = np.swapaxes(self.by_state, 1, 2) @ columns
        eliminated = np.swapaxes(solve_blocks(self.states, coupling), 1, 2)
        gradient = transposed @ self.residual[..., None]
        gradient -= eliminated @ self.own_gradient[..., None]
        squares = transposed @ columns
        return ByShot(
            own=squares - eliminated @ coupling,
            against=transposed @ self.shared,
            gradient=gradient[..., 0],
            raw=np.diagonal(squares, axis1=1, axis2=2),
        )

    def summed(self, channel: ByShot, basis: Floats) -> tuple[Floats, Floats]:
        """Return M and g of columns times a basis (S, K) over the shots, all that is fitted out.

        Shapes (K C, K C) and (K C,).
        """
        count = basis.shape[1] * channel.own.shape[1]
        own = np.einsum("sk,sl,sij->kilj", basis, basis, channel.own).reshape(count, count)
        against = np.einsum("sk,sip->kip", basis, channel.against).reshape(count, -1)
        gradient = np.einsum("sk,si->ki", basis, channel.gradient).ravel()
        imitated = against @ self.covariance
        return own - imitated @ against.T, gradient - imitated @ self.left

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
        chi2 = float(gradient @ amplitudes)
        by_shot = np.einsum("sk,si->ski", basis, channel.gradient).reshape(len(basis), -1)
        loudest = np.argsort(by_shot @ amplitudes)[-CARRIERS:]
        rest = gradient - by_shot[loudest].sum(axis=0)
        carried = 1.0 - float(rest @ covariance @ rest) / chi2 if chi2 > 0 else 0.0
        return Solved(amplitudes, covariance, chi2, int(seen.sum()), carried)


def projector(data: Data, fit: Fit) -> Projector:
    """Linearise about a fit and project."""
    line = linearise(data, fit.states, fit.theory)
    by_state = np.swapaxes(line.by_state, 1, 2)
    shared = line.by_theory - line.by_state @ solve_blocks(line.states, by_state @ line.by_theory)
    information = np.einsum("snp,snq->pq", line.by_theory, shared)
    centre, known = fit.theory.prior
    left = np.einsum("snp,sn->p", shared, line.residual) + (centre - fit.theory.vector) * known
    return Projector(
        residual=line.residual,
        by_state=line.by_state,
        states=line.states,
        own_gradient=line.own_gradient,
        shared=shared,
        covariance=inverse(with_prior(information, known)),
        held=fit.theory.held,
        left=left,
        noise=line.shared,
    )
