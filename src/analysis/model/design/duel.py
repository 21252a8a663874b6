"""One theory taken for true, and its rival refitted to what it foretells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from analysis.model.design.candidates import Candidates, foreseen, foreseen_shots
from analysis.model.design.divergence import Design, by_shot, refitted
from analysis.model.design.probability import named_over_none, named_over_rival
from analysis.model.fit import Fit
from analysis.model.normal import inverse, with_prior
from analysis.model.poses import PoseData
from analysis.model.state import ShotStates
from analysis.model.theory import Theory

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Duel:
    """What shots would show of the truth against its rival, to second order about a design.

    Attributes
    ----------
    campaign, settings
        Sums about the rival: of the campaign, and of one shot at each of K settings.
    known, shown
        Information on the true theory's parameters likewise, (P, P) and (K, P, P); what is known
        of them beforehand is in the first.
    amplitudes
        Of the true effect, the last parameters of its theory, shape (B,).
    more
        Parameters that the truth has more than its rival.
    shots
        Of the campaign.
    against_base
        Whether the rival is the base model.
    weight
        How far the campaign believes the truth, from 0 to 1.
    states, theory
        Where the rival stands: the shots' own numbers, and what they share.
    discounted
        Chi-squared between the two that is not counted.
    """

    campaign: Design
    settings: Design
    known: Floats
    shown: Floats
    amplitudes: Floats
    more: int
    shots: int
    against_base: bool
    weight: float
    states: ShotStates
    theory: Theory
    discounted: float = 0.0

    def apart(self, counts: Floats) -> float:
        """Return chi-squared that the rival leaves beside the campaign, for counts (K,)."""
        total = self.campaign.plus(self.settings.total(counts))
        return max(float(total.apart) - self.discounted, 0.0)

    def apart_with(self, counts: Floats) -> Floats:
        """Return the same with one more shot at each setting, shape (K,)."""
        total = self.campaign.plus(self.settings.total(counts))
        return np.maximum(total.plus(self.settings).apart - self.discounted, 0.0)

    def probability(self, counts: Floats) -> float:
        """Return how likely the truth is to be named."""
        apart = self.apart(counts)
        if self.against_base:
            return named_over_none(apart, len(self.amplitudes))
        return named_over_rival(
            self._strength(counts), apart, more=self.more, shots=self.shots + int(counts.sum())
        )

    def silenced(self) -> Duel:
        """Return the duel in which the campaign has no say of its own in who is right."""
        return replace(self, discounted=self.apart(np.zeros(len(self.settings.left))))

    def _strength(self, counts: Floats) -> float:
        """Return d^2 of the true effect: its amplitudes in units of what is known of them."""
        total = self.known + np.tensordot(counts, self.shown, 1)
        size = len(self.amplitudes)
        own = inverse(total)[-size:, -size:]
        return float(self.amplitudes @ np.linalg.solve(own, self.amplitudes))


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


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """A theory taken for true, over the campaign and the shots that could be fired.

    Attributes
    ----------
    campaign, shots
        Poses as it foretells them, free of noise: of the campaign and of the drawn shots.
    known, shown
        As in `Duel`.
    weight
        How far the campaign believes it.
    """

    drawn: Candidates
    true: Fit
    rival: Fit
    campaign: PoseData
    shots: PoseData
    known: Floats
    shown: Floats
    weight: float

    def duel(self, counts: Floats, start: Duel | None = None) -> Duel:
        """Refit the rival to the campaign with so many shots at each setting.

        Parameters
        ----------
        start
            The duel about an earlier design, to begin with.
        """
        both = _joined(self.campaign, self.shots)
        states = ShotStates.joined([self.true.states, self.drawn.states])
        theory = self.rival.theory
        if start is not None:
            states, theory = start.states, start.theory
        old = len(self.campaign.shots)
        weights = np.concatenate([np.ones(old), self.drawn.spread(counts)])
        states, theory = refitted(both, states, theory, weights)
        sums = by_shot(both, states, theory)
        campaign = sums.total(np.where(np.arange(len(weights)) < old, 1.0, 0.0))
        own = len(self.true.theory.active[-1].values)
        more = len(self.true.theory.names) - len(self.rival.theory.names)
        return Duel(
            campaign=replace(campaign, matrix=with_prior(campaign.matrix, theory.prior[1])),
            settings=Design(
                self.drawn.averaged(sums.left[old:]),
                self.drawn.averaged(sums.gradient[old:]),
                self.drawn.averaged(sums.matrix[old:]),
            ),
            known=self.known,
            shown=self.shown,
            amplitudes=self.true.theory.vector[-own:],
            more=more,
            shots=old,
            against_base=len(self.rival.theory.active) < len(self.true.theory.active),
            weight=self.weight,
            states=states,
            theory=theory,
        )


def truth(data: PoseData, drawn: Candidates, true: Fit, rival: Fit, weight: float) -> Truth:
    """Foretell campaign and candidates by the fit that is taken for true."""
    shots = foreseen_shots(drawn, true.theory)
    campaign = foreseen(data, true.states, true.theory)
    return Truth(
        drawn=drawn,
        true=true,
        rival=rival,
        campaign=campaign,
        shots=shots,
        known=with_prior(
            by_shot(campaign, true.states, true.theory).matrix.sum(axis=0), true.theory.prior[1]
        ),
        shown=drawn.averaged(by_shot(shots, drawn.states, true.theory).matrix),
        weight=weight,
    )


def _near(apart: Floats) -> Floats:
    # Minus the doubt: the probability itself has no digits left beyond 8 sigmas.
    return np.asarray(-ndtr(-np.sqrt(apart) / 2))


def _joined(first: PoseData, second: PoseData) -> PoseData:
    """Return the shots of both, which have as many frames."""
    names = ("shots", "times_s", "position", "position_sigma", "rotation", "rotation_sigma")
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(first, name), getattr(second, name)]) for name in names
    }
    covariates = {k: np.concatenate([v, second.covariates[k]]) for k, v in first.covariates.items()}
    return replace(first, **arrays, covariates=covariates)
