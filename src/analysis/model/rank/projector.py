"""A fit seen to first order, with everything that was fitted projected out.

Each shot's own numbers are eliminated shot by shot (Schur complement), then what all shots share:
what is left of any column is what no fitted number can imitate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.normal import inverse, solve_blocks, with_prior
from analysis.model.fitting.shared_noise import SharedNoise
from analysis.model.fitting.slow_errors.field import NO_FIELDS, FieldErrors
from analysis.model.predict.linear import linearise
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

LEAST_EIGENVALUE = 1e-3
"""Below this share a direction is only the rounding of differences."""
LEAST_INFORMATION = 1e-6
"""A column of which less is left is what a fitted number does already."""


class ByShot(NamedTuple):
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
    """Amplitudes of C columns, shape (C,), and their covariance.

    Both are zero along what cannot be seen; chi2 is the fall that they bring, freedom the number of
    directions that are seen.
    """

    amplitudes: Floats
    covariance: Floats
    chi2: float
    freedom: int


@dataclass(frozen=True, slots=True, eq=False)
class ColumnSums:
    """What C columns add up to over shots, each shot's own numbers eliminated.

    own (C, C), against (C, P) with the fitted parameters, gradient (C,); raw (C,) is what the
    squares were before anything was eliminated.
    """

    own: Floats
    against: Floats
    gradient: Floats
    raw: Floats

    @classmethod
    def of(cls, channel: ByShot) -> ColumnSums:
        """Add up over the shots."""
        return cls(*(part.sum(axis=0) for part in channel))

    def __add__(self, other: ColumnSums) -> ColumnSums:
        """Return the sums over the shots of both."""
        return ColumnSums(
            self.own + other.own,
            self.against + other.against,
            self.gradient + other.gradient,
            self.raw + other.raw,
        )

    def of_first(self) -> ColumnSums:
        """Return the sums of the first column alone."""
        return ColumnSums(self.own[:1, :1], self.against[:1], self.gradient[:1], self.raw[:1])

    def solved(self, covariance: Floats, left: Floats) -> Solved:
        """Fit amplitudes beside all that was fitted.

        Parameters
        ----------
        covariance, left
            Of the fitted parameters, as `Projector` has them.
        """
        imitated = self.against @ covariance
        matrix, gradient = self.own - imitated @ self.against.T, self.gradient - imitated @ left
        shown = np.flatnonzero(np.diag(matrix) > LEAST_INFORMATION * self.raw)
        root = np.sqrt(np.diag(self.own)[shown])
        scaled = matrix[np.ix_(shown, shown)] / root[:, None] / root[None, :]
        values, vectors = np.linalg.eigh(scaled)
        seen = values > LEAST_EIGENVALUE
        along = np.zeros((len(matrix), int(seen.sum())))
        along[shown] = vectors[:, seen] / root[:, None]
        spread = (along / values[seen]) @ along.T
        amplitudes = spread @ gradient
        return Solved(amplitudes, spread, float(gradient @ amplitudes), int(seen.sum()))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Eliminated:
    """Shots linearised about a fit, their own numbers eliminated: S shots, N whitened numbers each.

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
        Derivatives by the P shared parameters less what the shot's own numbers can imitate, shape
        (S, N, P).
    """

    residual: Floats
    by_state: Floats
    states: Floats
    own_gradient: Floats
    shared: Floats
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


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Projector(Eliminated):
    """A linearised fit of all its shots.

    Attributes
    ----------
    covariance
        Of the shared parameters, shape (P, P).
    held
        Of `Theory.held`, shapes (P,).
    left
        Downhill by the shared parameters, the prior in, shape (P,): little, for a fit ends before
        its very minimum. A direction that they nearly imitate would show all of it.
    """

    covariance: Floats
    held: tuple[Floats, Floats]
    left: Floats


def projector(data: Data, fit: Fit, field: FieldErrors = NO_FIELDS) -> Projector:
    """Linearise about a fit and project; the columns of a field follow the fitted parameters."""
    own, information, downhill = eliminated(data, fit.states, fit.theory, field)
    centre, known = field.beside(*fit.theory.prior)
    vector = field.beside(fit.theory.vector, known)[0]
    return Projector(
        **{name: getattr(own, name) for name in Eliminated.__slots__},
        covariance=inverse(with_prior(information, known)),
        held=field.beside(*fit.theory.held),
        left=downhill + (centre - vector) * known,
    )


def eliminated(
    data: Data, states: ShotStates, theory: Theory, field: FieldErrors = NO_FIELDS
) -> tuple[Eliminated, Floats, Floats]:
    """Linearise shots about a fit, and eliminate their own numbers.

    The columns of a field of errors are shared as the fitted parameters are, and follow them.

    Returns
    -------
    The shots; what they add to the information on the shared parameters (P, P), and to what is
    downhill by them, (P,).
    """
    line = linearise(data, states, theory, given=field.columns(data))
    shared, information, downhill = line.without_states()
    own = Eliminated(
        residual=line.residual,
        by_state=line.by_state,
        states=line.states,
        own_gradient=line.own_gradient,
        shared=shared,
        noise=line.shared,
    )
    return own, information, downhill
