"""By how much the truth would lead its rival once more shots are in, given what a campaign shows.

Of every shot count the Gram matrix of three things, its own numbers eliminated: derivatives by what
the truth T has and by what its rival R has, each about its own fit, and d, what sets the two fits
apart. With noise u the chi-squareds differ by

    d'd + 2 d'u - (d + u)' R (R'R)^-1 R' (d + u) + u' T (T'T)^-1 T' u

In the campaign's shots u is known. In new ones it is the noise and, as far as the campaign leaves
the truth's parameters open, T times what they are off.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.parts import SHOTS_AT_ONCE
from analysis.model.data.poses import PoseData
from analysis.model.fitting.normal import inverse, solve_blocks, with_prior
from analysis.model.predict.linear import linearise
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

DRAWS = 4000
"""Futures that are drawn: a probability of 0.9 is then known to 0.005."""
Stand = tuple[ShotStates, Theory]


@dataclass(frozen=True, slots=True, eq=False)
class Leads:
    """A truth of P parameters, its rival of R, and Q = P + R + 1.

    Attributes
    ----------
    campaign, settings
        Gram matrices of the campaign, (Q, Q), and of one shot at each of K settings, (K, Q, Q).
    observed
        What the campaign's residuals about the truth have along each column, shape (Q,).
    priors
        Pull and information by what is known of the parameters beforehand: the truth's, the
        rival's, each of shapes (P,) or (R,).
    shots
        Of the campaign.
    ahead
        By how much the truth leads there, ln(shots) counted for each parameter.
    """

    campaign: Floats
    settings: Floats
    observed: Floats
    priors: tuple[tuple[Floats, Floats], tuple[Floats, Floats]]
    shots: int
    ahead: float

    def after(self, counts: Floats) -> Floats:
        """Return the leads after so many shots at each setting (K,), in drawn futures, (DRAWS,)."""
        own, size = len(self.priors[0][0]), len(self.observed)
        rng = np.random.default_rng(0)
        off, noise = rng.standard_normal((DRAWS, own)), rng.standard_normal((DRAWS, size))
        more = np.tensordot(counts, self.settings, 1)
        known = inverse(with_prior(self.campaign[:own, :own], self.priors[0][1]))
        shown = noise @ _root(more).T + off @ (more[:, :own] @ _root(known)).T
        now = float(self._lead(self.campaign, self.observed))
        price = (self._parameters[0] - self._parameters[1]) * np.log1p(counts.sum() / self.shots)
        then = self._lead(self.campaign + more, self.observed + shown)
        return np.asarray(self.ahead + then - now - price)

    @property
    def _parameters(self) -> tuple[int, int]:
        return len(self.priors[0][0]), len(self.priors[1][0])

    def _lead(self, gram: Floats, along: Floats) -> Floats:
        """Return the lead for residuals that have so much along the columns, (..., Q) to (...)."""
        own = len(self.priors[0][0])
        apart, rival = gram[-1], slice(own, -1)
        lead = np.asarray(apart[-1] + 2 * along[..., -1])
        for sign, part, right, (pull, information) in (
            (1.0, slice(0, own), along[..., :own], self.priors[0]),
            (-1.0, rival, along[..., rival] + apart[rival], self.priors[1]),
        ):
            downhill = right + pull
            solved = downhill @ inverse(with_prior(gram[part, part], information))
            lead = lead + sign * (downhill * solved).sum(axis=-1)
        return lead


def grams(foretold: PoseData, true: Stand, rival: Stand) -> Floats:
    """Return the Gram matrix of every shot, shape (S, Q, Q).

    Parameters
    ----------
    foretold
        What the truth shows, free of noise.
    true, rival
        Where both stand in these shots.
    """
    parts = [columns for _, columns in _parts(foretold, true, rival)]
    return np.concatenate([np.swapaxes(part, 1, 2) @ part for part in parts])


def observed(data: PoseData, foretold: PoseData, true: Stand, rival: Stand) -> Floats:
    """Return what the residuals of measured shots about the truth have along each column, (Q,)."""
    found = []
    for some, columns in _parts(foretold, true, rival):
        line = linearise(data.part(some), true[0].of_shots(some), true[1])
        found.append(np.einsum("snq,sn->q", columns, line.residual))
    return np.asarray(np.sum(found, axis=0))


def pulled(theory: Theory) -> tuple[Floats, Floats]:
    """Return the pull of what is known beforehand on each parameter, and its information, (P,)."""
    centre, information = theory.prior
    return (centre - theory.vector) * information, information


def _parts(foretold: PoseData, true: Stand, rival: Stand) -> Iterator[tuple[slice, Floats]]:
    """Give the columns (S, N, Q) of some shots at a time, their own numbers eliminated."""
    count = len(foretold.shots)
    for start in range(0, count, SHOTS_AT_ONCE):
        some = slice(start, min(start + SHOTS_AT_ONCE, count))
        part = foretold.part(some)
        first, second = (linearise(part, s.of_shots(some), t) for s, t in (true, rival))
        columns = np.concatenate(
            [first.by_theory, second.by_theory, second.residual[..., None]], axis=2
        )
        own = np.swapaxes(first.by_state, 1, 2) @ columns
        yield some, columns - first.by_state @ solve_blocks(first.states, own)


def _root(covariance: Floats) -> Floats:
    """Return a root of a covariance that may be singular."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / scale[:, None] / scale)
    return np.asarray(scale[:, None] * (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T)
