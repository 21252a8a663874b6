"""One theory taken for true, its rival refitted to what it foretells, and how far it then leads.

`Leads` says it of futures: once more shots are in, given what a campaign shows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chndtr, ndtr

from analysis import chi_squared
from analysis.arrays import Floats
from analysis.model.data.parts import SHOTS_AT_ONCE
from analysis.model.data.poses import PoseData
from analysis.model.design.candidates import Candidates, foreseen, foreseen_shots
from analysis.model.design.divergence import Design, by_shot, refitted
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.normal import inverse, solve_blocks, with_prior
from analysis.model.predict.linear import linearise
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

LEVEL = 0.001
"""Chance of a fall of chi-squared large enough for an effect to be named when nothing is missing:
three campaigns in a hundred among some thirty that are looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class Duel:
    """What shots would show of the truth against its rival, to second order about a design.

    Attributes
    ----------
    campaign, settings
        Sums about the rival: of the campaign, and of one shot at each of K settings.
    leads
        By how much the truth leads after more shots; None: the rival is the base model, and the
        truth is named where it passes the level.
    parameters
        Of the true effect.
    weight, noise
        How far the campaign believes the truth, from 0 to 1, and the variance of its residuals, in
        squares of the stated sigmas.
    stand
        Where the rival stands: the shots' own numbers, and what they share.
    """

    campaign: Design
    settings: Design
    leads: Leads | None
    parameters: int
    weight: float
    noise: float
    stand: Stand

    def apart(self, counts: Floats) -> float:
        """Return chi-squared that the rival leaves beside the campaign, for counts (K,)."""
        total = self.campaign.plus(self.settings.total(counts))
        return float(total.apart)

    def apart_with(self, counts: Floats) -> Floats:
        """Return the same with one more shot at each setting, shape (K,)."""
        total = self.campaign.plus(self.settings.total(counts))
        return total.plus(self.settings).apart

    def probability(self, counts: Floats) -> float:
        """Return how likely the truth is to be named."""
        if self.leads is None:
            return named_over_none(self.apart(counts) / self.noise, self.parameters)
        return float((self.leads.after(counts) > 0).mean())


@dataclass(frozen=True, slots=True, eq=False)
class Duels:
    """Either theory taken for true: what a choice of shots makes large (`choice.Aim`)."""

    duels: tuple[Duel, ...]

    @property
    def size(self) -> int:
        """Number of settings."""
        return len(self.duels[0].settings.left)

    def worth(self, counts: Floats) -> float:
        """Return minus the chance of naming the wrong one, where the effects are near aliases.

        Phi(sqrt(chi-squared between them) / 2), as the campaign believes either.
        """
        return float(_near(np.array([duel.apart(counts) for duel in self.duels])) @ self._weights)

    def worth_with(self, counts: Floats) -> Floats:
        """Return the same with one more shot at each setting, shape (K,)."""
        apart = np.stack([duel.apart_with(counts) for duel in self.duels], axis=-1)
        return np.asarray(_near(apart) @ self._weights)

    def probability(self, counts: Floats) -> float:
        """Return how likely the right one is to be named."""
        return sum(duel.weight * duel.probability(counts) for duel in self.duels)

    def reaching(self, probability: float) -> Callable[[Floats], bool]:
        """Return what says whether a design is as likely to name the right one as is asked."""
        return lambda counts: self.probability(counts) >= probability

    @property
    def _weights(self) -> Floats:
        return np.array([duel.weight for duel in self.duels])


@dataclass(frozen=True, slots=True)
class Belief:
    """How far a campaign believes a theory.

    Attributes
    ----------
    weight
        From 0 to 1.
    ahead
        By how much the theory leads its rival in chi-squared, ln(shots) counted for each parameter;
        None: its rival is the base model.
    noise
        Variance of the campaign's residuals, in squares of the stated sigmas.
    """

    weight: float = 1.0
    ahead: float | None = None
    noise: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """A theory taken for true, over the campaign and the shots that could be fired.

    Attributes
    ----------
    data
        The campaign as it was measured.
    foretold
        Poses of the campaign's shots and then of the drawn ones as the theory has them, free of
        noise.
    """

    drawn: Candidates
    true: Fit
    rival: Fit
    data: PoseData
    foretold: PoseData
    belief: Belief

    def duel(self, counts: Floats, start: Duel | None = None) -> Duel:
        """Refit the rival to the campaign with so many shots at each setting.

        Parameters
        ----------
        start
            The duel about an earlier design, to begin with.
        """
        true = (ShotStates.joined([self.true.states, self.drawn.states]), self.true.theory)
        states, theory = (true[0], self.rival.theory) if start is None else start.stand
        old = len(self.data.shots)
        weights = np.concatenate([np.ones(old), self.drawn.spread(counts)])
        rival = refitted(self.foretold, states, theory, weights)
        sums = by_shot(self.foretold, *rival)
        campaign = sums.total(np.where(np.arange(len(weights)) < old, 1.0, 0.0))
        return Duel(
            campaign=replace(campaign, matrix=with_prior(campaign.matrix, rival[1].prior[1])),
            settings=Design(
                self.drawn.averaged(sums.left[old:]),
                self.drawn.averaged(sums.gradient[old:]),
                self.drawn.averaged(sums.matrix[old:]),
            ),
            leads=self._leads(true, rival),
            parameters=len(self.true.theory.active[-1].values),
            weight=self.belief.weight,
            noise=self.belief.noise,
            stand=rival,
        )

    def _leads(self, true: Stand, rival: Stand) -> Leads | None:
        if self.belief.ahead is None:
            return None
        old, noise = len(self.data.shots), self.belief.noise
        gram = grams(self.foretold, true, rival) / noise
        return Leads(
            campaign=gram[:old].sum(axis=0),
            settings=self.drawn.averaged(gram[old:]),
            observed=observed(self.data, self.foretold.part(slice(old)), true, rival) / noise,
            priors=(pulled(true[1]), pulled(rival[1])),
            shots=old,
            ahead=self.belief.ahead,
        )


def truth(data: PoseData, drawn: Candidates, true: Fit, rival: Fit, belief: Belief) -> Truth:
    """Foretell campaign and candidates by the fit that is taken for true."""
    campaign = foreseen(data, true.states, true.theory)
    foretold = PoseData.joined([campaign, foreseen_shots(drawn, true.theory)])
    return Truth(drawn, true, rival, data, foretold, belief)


def _near(apart: Floats) -> Floats:
    # Minus the doubt: the probability itself has no digits left beyond 8 sigmas.
    return np.asarray(-ndtr(-np.sqrt(apart) / 2))


def named_over_none(apart: float, parameters: int) -> float:
    """Return the probability that a true effect passes the level at which it is named.

    Parameters
    ----------
    apart
        Chi-squared that the base model leaves without the effect.
    parameters
        Of the effect.
    """
    least = chi_squared.limit(LEVEL, parameters)
    return 1.0 - float(chndtr(least, parameters, max(apart, 1e-12)))


DRAWS = 4000
"""Futures that are drawn: a probability of 0.9 is then known to 0.005."""
Stand = tuple[ShotStates, Theory]


@dataclass(frozen=True, slots=True, eq=False)
class Leads:
    """By how much a truth of P parameters leads its rival of R once more shots are in.

    Of every shot count the Gram matrix of Q = P + R + 1 columns, its own numbers eliminated:
    derivatives by what the truth T has and by what its rival R has, each about its own fit, and d,
    what sets the two fits apart. With noise u the chi-squareds differ by

        d'd + 2 d'u - (d + u)' R (R'R)^-1 R' (d + u) + u' T (T'T)^-1 T' u

    In the campaign's shots u is known. In new ones it is the noise and, as far as the campaign
    leaves the truth's parameters open, T times what they are off.

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
