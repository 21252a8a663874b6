"""Fitting a campaign: every shot's own numbers eliminated, what all shots share fitted jointly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from analysis.collision.operator import WaltonLaw
from analysis.model.data.parts import in_memory, parts_of
from analysis.model.data.tables import Data
from analysis.model.data.unseen import fitted_numbers
from analysis.model.fitting.gauss_newton import TO_THE_END, Purpose, descended, linearised, summed
from analysis.model.fitting.normal import NormalEquations, inverse, prior_cost
from analysis.model.fitting.own_fit import own_states
from analysis.model.fitting.summary import FitSummary
from analysis.model.fitting.systematics import Systematic
from analysis.model.predict.start import first_states
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import LAW, LAW_PRIOR, Theory

F = TypeVar("F", bound=FitSummary)

START = WaltonLaw(*LAW_PRIOR)
FEW = 30
OTHER_STARTS = (WaltonLaw(0.74, 0.08, 0.2), WaltonLaw(0.74, 0.12, 0.6), WaltonLaw(0.74, 0.05, 0.4))
"""Where so few shots are fitted from as well: one that lies between rolling and sliding can hold
the law on its wrong side, where too few others pull."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Fit(FitSummary):
    """A fitted campaign.

    Attributes
    ----------
    states
        The shots' own numbers.
    """

    states: ShotStates


def fit_campaign(
    data: Data,
    theory: Theory | None = None,
    start: Fit | None = None,
    purpose: Purpose = TO_THE_END,
) -> Fit:
    """Fit what all shots share together with every shot's own numbers.

    Parameters
    ----------
    theory
        Law and effects to start from; None: the hard-sphere operator alone.
    start
        An earlier fit of the same data whose states are taken over. Without one each shot is
        first fitted by itself.
    purpose
        How far it is to be followed.
    """
    if theory is None and start is None:
        begun = starting_theories(len(data.shots), data.systematics)
        return likeliest([fit_campaign(data, one) for one in begun])
    present = Theory(START, data.systematics) if theory is None else theory
    if start is None:
        guessed = parts_of(data, first_states(data))
        parts = [(part, own_states(part, states, present)) for part, states in guessed]
    else:
        parts = list(parts_of(data, start.states))
    first = linearised((summed(*part, present) for part in parts), present, in_memory)
    measured, own = data.measured.reshape(len(data.shots), -1).sum(axis=1), fitted_numbers(data)
    freedom = np.maximum(measured - own, 1.0)
    last, converged = descended([part for part, _ in parts], first, in_memory, freedom, purpose)
    stands = list(last.stands)
    chi2 = np.concatenate([stand.chi2 for stand in stands])
    return Fit(
        theory=last.theory,
        states=ShotStates.joined([stand.states for stand in stands]),
        covariance=inverse(last.matrix),
        chi2=float(chi2.sum()) + last.theory.strain,
        residuals=int(measured.sum()) + last.theory.given - len(LAW),
        shot_chi2=chi2,
        shot_residuals=measured,
        own_numbers=own,
        converged=converged,
        scatter=start.scatter if start is not None and data.jitter_s > 0 else {},
    )


def starting_theories(shots: int, systematics: tuple[Systematic, ...]) -> list[Theory]:
    """Return where a fit of so many shots begins: the hard-sphere operator, of few at more laws."""
    laws = (START, *OTHER_STARTS) if shots <= FEW else (START,)
    return [Theory(law, systematics) for law in laws]


def likeliest(fits: Sequence[F]) -> F:
    """Return the fit of the least chi-squared, the prior in."""
    return min(fits, key=lambda fit: fit.chi2 + prior_cost(fit.theory))


def normal_equations(data: Data, states: ShotStates, theory: Theory) -> NormalEquations:
    """Linearise about states and theory and sum up by shot."""
    return NormalEquations.joined([summed(*part, theory)[1] for part in parts_of(data, states)])
