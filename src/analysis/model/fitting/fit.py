"""Fitting a campaign: every shot's own numbers eliminated, what all shots share fitted jointly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import WaltonLaw
from analysis.model.data.parts import Kept, cut, regrouped
from analysis.model.data.stream import CampaignData, beside
from analysis.model.data.tables import ContactTable, Data
from analysis.model.data.unseen import fitted_numbers
from analysis.model.fitting.gauss_newton import (
    TO_THE_END,
    WORSE,
    Purpose,
    descended,
    linearised,
    summed,
)
from analysis.model.fitting.normal import NormalEquations, inverse, prior_cost
from analysis.model.fitting.own_fit import own_states
from analysis.model.fitting.slow_errors.field import explained_by, field_errors, with_field
from analysis.model.fitting.summary import FitSummary
from analysis.model.predict.start import first_states
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import LAW, LAW_PRIOR, Theory

START = WaltonLaw(*LAW_PRIOR)
MISLEADING = 1.5
"""Chi-squared per degree of freedom of a fit whose states are no start for another."""
RARE, MOST_BY_FIELD = 0.01, 1.5
"""Chance of a chi-squared below which it is more than noise, and per degree of freedom beyond which
it is more than a field of errors leaves."""
FEW = 30
ENOUGH_TO_BEGIN, MANY = 128, 512
"""Shots from which the law is found first, of as many as it saves steps for."""
OTHER_STARTS = (WaltonLaw(0.74, 0.08, 0.2), WaltonLaw(0.74, 0.12, 0.6), WaltonLaw(0.74, 0.05, 0.4))
"""Where so few shots are fitted from as well: one that lies between rolling and sliding can hold
the law on its wrong side, where too few others pull."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Fit(FitSummary):
    """A fitted campaign.

    Attributes
    ----------
    parts
        The shots' own numbers, part by part.
    """

    parts: Kept[ShotStates]

    @property
    def states(self) -> ShotStates:
        """The shots' own numbers, all in memory."""
        return ShotStates.joined(list(self.parts))

    def with_states(self, states: ShotStates) -> Fit:
        """Return the fit with other numbers of the shots, of a campaign in memory."""
        return replace(self, parts=list(cut(states)))


def fit_campaign(
    data: CampaignData,
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
        An earlier fit of the same shots whose states are taken over. Without one each shot is
        first fitted by itself.
    purpose
        How far it is to be followed.

    Raises
    ------
    OSError
        The campaign lies in a file, and the temporary folder is full.
    """
    if theory is None and start is None:
        return likeliest([fit_campaign(data, one) for one in _starting_theories(data)])
    present = Theory(START, data.systematics) if theory is None else theory
    if start is not None and _misled(data, start):
        calibrated = (replace(s, values=s.stated) for s in present.systematics)
        present, start = replace(present, systematics=tuple(calibrated)), None
    states = _by_themselves(data, present) if start is None else start.parts
    begun_at = (summed(part, own, present) for part, own in beside(data, states))
    measured, own = _counts(data)
    freedom = np.maximum(measured - own, 1.0)
    last, converged = descended(data, linearised(begun_at, present, data.keep), freedom, purpose)
    parts = data.keep(ShotStates)
    for stand in last.stands:
        parts.append(stand.states)
    chi2 = np.concatenate([stand.chi2 for stand in last.stands])
    return Fit(
        theory=last.theory,
        parts=parts,
        covariance=inverse(last.matrix),
        chi2=float(chi2.sum()) + last.theory.strain,
        residuals=int(measured.sum()) + last.theory.given - len(LAW),
        shot_chi2=chi2,
        shot_residuals=measured,
        nuisance_count=own,
        converged=converged,
        scatter=start.scatter if start is not None and data.jitter_s > 0 else {},
    )


def fit_afresh(data: CampaignData, fit: Fit) -> Fit:
    """Fit again at a law that is known by now, each shot begun anew where that is likelier.

    Parameters
    ----------
    fit
        Of the same shots, their sigmas as they are in `data` or enlarged.
    """
    chosen, theory = data.keep(ShotStates), fit.theory
    for part, states in parts_of(data, fit):
        begun = own_states(part, first_states(part), theory)
        stands, begins = (summed(part, own, theory)[1].chi2 for own in (states, begun))
        chosen.append(states.chosen(begun, begins < stands - WORSE))
    return fit_campaign(data, theory, replace(fit, parts=chosen))


def beside_field(data: CampaignData, fit: Fit) -> Fit:
    """Return a fit with what a field of errors does to its parameters and its chi-squared.

    What a fit is judged by or handed on with has to hold it; those on the way to it do without.
    Only where chi-squared is more than chance and yet near the noise is it asked what of it a field
    explains.
    """
    if fit.by_field is not None:
        return fit
    field, theory = field_errors(data), fit.theory
    if not field.count:
        return replace(fit, by_field=0.0)
    covariance = with_field(fit.covariance, field, parts_of(data, fit), theory)
    in_question = fit.p_chi2 < RARE and fit.chi2_per_dof < MOST_BY_FIELD
    by_field = explained_by(field, parts_of(data, fit), theory) if in_question else 0.0
    return replace(fit, covariance=covariance, by_field=by_field)


def _misled(data: CampaignData, start: Fit) -> bool:
    """Whether shots and errors of the measurement are better begun anew than where a fit has them.

    Bounces on a plate bend with a law that is far off, and hold the next one where they are.
    """
    if isinstance(data, ContactTable) or not data.bodies[1].is_plate:
        return False
    return start.chi2_per_dof > MISLEADING


def parts_of(data: CampaignData, fit: Fit) -> Iterator[tuple[Data, ShotStates]]:
    """Go over a campaign and its fit: data and states of so many shots at a time, in order."""
    return beside(data, fit.parts)


def states_of_shots(data: CampaignData, fit: Fit, chosen: NDArray[np.bool_]) -> Kept[ShotStates]:
    """Return the own numbers of some shots of a fit, mask of shape (S,), in parts of theirs."""

    def left() -> Iterator[ShotStates]:
        start = 0
        for states in fit.parts:
            own = slice(start, start + states.count)
            start = own.stop
            yield states.of_shots(chosen[own])

    kept = data.keep(ShotStates)
    for states in regrouped(left()):
        kept.append(states)
    return kept


def _by_themselves(data: CampaignData, theory: Theory) -> Iterator[ShotStates]:
    return (own_states(part, first_states(part), theory) for part in data.parts())


def _counts(data: CampaignData) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the measured numbers of each shot, and how many of its own they determine, (S,)."""
    measured, own = [], []
    for part in data.parts():
        measured.append(part.measured.reshape(part.count, -1).sum(axis=1))
        own.append(fitted_numbers(part))
    return np.concatenate(measured), np.concatenate(own)


def _starting_theories(data: CampaignData) -> list[Theory]:
    """Return where a fit begins: the hard-sphere operator, and of few shots at more laws.

    Of many, the law is first found from some that are spread over the campaign.
    """
    shots = len(data.shots)
    if shots >= MANY:
        some = np.arange(shots) % (shots // ENOUGH_TO_BEGIN) == 0
        return [fit_campaign(data.of_shots(some)).theory]
    laws = (START, *OTHER_STARTS) if shots <= FEW else (START,)
    return [Theory(law, data.systematics) for law in laws]


def likeliest(fits: Sequence[Fit]) -> Fit:
    """Return the fit of the least chi-squared, the prior in."""
    return min(fits, key=lambda fit: fit.chi2 + prior_cost(fit.theory))


def normal_equations(data: Data, states: ShotStates, theory: Theory) -> NormalEquations:
    """Linearise about states and theory and sum up by shot, all in memory."""
    parts = beside(data, cut(states))
    return NormalEquations.joined([summed(part, own, theory)[1] for part, own in parts])
