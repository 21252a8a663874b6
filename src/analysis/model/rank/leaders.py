"""Candidates refitted: which of them really brings chi-squared down, and which look alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import ScatterEffect
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.adding import ALIAS_WITHIN, added
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.fitting.gauss_newton import Purpose
from analysis.model.fitting.normal import prior_cost
from analysis.model.rank.candidate import Candidate, Ranking, believed
from analysis.model.rank.scatter import with_jitter
from analysis.model.structure.influence import most_carried

FIRST_LEVEL, LATER_LEVEL = 0.03, 0.01
"""Family-wise level of the first acceptance and of each later one: the stricter keeps out shadows
of an effect already accepted."""
MOST_REFITTED = 10
SMALL_FALL = 64.0
"""Eight standard errors: refits then bring the expected drop."""
LEAST_EXPECTED = 0.1
"""Share of the largest expected drop below which no refit comes out first, however large."""
DURATION_SIGMAS = 3.0
"""A duration that is not so many standard errors from zero is that of no lasting contact."""
WITHIN = 0.03
"""Share of the best fall by which a rough fit may be behind, and come out first or alike."""
BELIEVED_SHARE = 0.2
"""A plausible effect goes before an implausible one if it has this share of its fall."""


@dataclass(frozen=True, slots=True, eq=False)
class Leader:
    """A refitted candidate.

    Attributes
    ----------
    data
        The data it was fitted to: with a scatter in, their noise is another.
    values
        Of its parameters, as fitted.
    delta_chi2
        Of chi-squared, as the refit really brought it.
    criterion
        Fall in units of the noise, less ln(shots) for each parameter: half of BIC's difference.
    plausible
        Whether its values are believed.
    carried
        Whether it rests on two shots alone.
    """

    candidate: Candidate
    data: CampaignData
    fit: Fit
    values: Floats
    delta_chi2: float
    criterion: float
    plausible: bool
    carried: bool

    @property
    def name(self) -> str:
        """Of its effect."""
        return self.candidate.effect.name

    @property
    def unbiased_delta_chi2(self) -> float:
        """Fall in units of the noise, less what chance alone brings."""
        return self.delta_chi2 / max(self.fit.chi2_per_dof, 1e-12) - self.candidate.freedom


def refitted(
    data: CampaignData,
    fit: Fit,
    ranking: Ranking,
    level: float,
    *,
    least: float = 0.0,
    beat: float = np.inf,
) -> list[Leader]:
    """Refit candidates whose expected drop passes a family-wise level, and mark the carried ones.

    One is carried if two shots hold most of its drop and the others alone do not pass. Those
    whose likelihood ratio, after the refit, no longer passes are left out.

    Parameters
    ----------
    least
        Expected drop below which none is refitted: what else may go in brings more.
    beat
        Cost of a fit with what else may go in: a refit that stays above it is left.
    """
    invited = [
        c
        for c in ranking.candidates
        if c.seen and not c.of_measurement and c.p_familywise < level and c.delta_chi2 >= least
    ]
    threshold, most = ranking.threshold(level), most_carried(len(data.shots))
    leaders: list[Leader] = []
    for c in _worth_it(invited, len(data.shots)):
        carried = c.carried_share >= most and _by_others(c) > threshold * c.weight
        leader = _refit(data, fit, c, min(beat, _bar(leaders, WITHIN)), carried=carried)
        leaders += [] if leader is None else [leader]
    if not leaders:
        return []
    leaders = _settled(fit, leaders, beat)
    noise = min(leader.fit.chi2_per_dof for leader in leaders)
    return [
        leader
        for leader in leaders
        if leader.candidate.chance_of(leader.delta_chi2 / noise, leader.values)
        <= threshold * leader.candidate.weight
    ]


def _bar(leaders: Sequence[Leader], within: float) -> float:
    """Return the chi-squared above which a further refit can be neither first nor alike.

    One that is not believed, or that two shots carry, may have to make room, and sets no bar.

    Parameters
    ----------
    within
        Share of the best fall by which refits may still come nearer.
    """
    sure = [leader for leader in leaders if leader.plausible and not leader.carried]
    if not sure:
        return float(np.inf)
    best = min(sure, key=lambda leader: leader.fit.chi2)
    alike = 2 * ALIAS_WITHIN * max(best.fit.chi2_per_dof, 1.0)
    return best.fit.chi2 + prior_cost(best.fit.theory) + max(within * best.delta_chi2, alike)


def _settled(fit: Fit, leaders: Sequence[Leader], beat: float) -> list[Leader]:
    """Follow the fits to their end that may come out first, or look like the one that does."""
    best = min(leaders, key=lambda leader: leader.fit.chi2)
    near = min(best.fit.chi2 + WITHIN * max(best.delta_chi2, 0.0), beat)
    settled: list[Leader] = []
    for leader in sorted(leaders, key=lambda each: each.fit.chi2):
        if leader.fit.converged or leader.fit.chi2 > near:
            settled.append(leader)
            continue
        bar = min(beat, _bar([each for each in settled if each.fit.converged], 0.0))
        followed = fit_campaign(leader.data, leader.fit.theory, leader.fit, Purpose(beat=bar))
        settled.append(
            _leader(leader.candidate, leader.data, (fit, followed), carried=leader.carried)
        )
    return settled


def _by_others(candidate: Candidate) -> float:
    """Return the chance of the drop expected without the two most influential shots."""
    delta_chi2 = candidate.delta_chi2 * (1 - candidate.carried_share)
    return candidate.chance_of(delta_chi2, candidate.amplitudes)


def _worth_it(candidates: Sequence[Candidate], shots: int) -> Sequence[Candidate]:
    """Return which candidates a refit may still put first.

    Scores of small effects are exact, and tell by themselves who is far behind; those of large
    ones are not, nor does one of them take second place to a doubtful one.
    """
    if not candidates:
        return candidates
    least = LEAST_EXPECTED * candidates[0].delta_chi2
    candidates = [candidate for candidate in candidates if candidate.delta_chi2 > least]
    if candidates[0].delta_chi2 > SMALL_FALL or not candidates[0].plausible:
        return candidates[:MOST_REFITTED]
    worth = [c.delta_chi2 - c.freedom * float(np.log(max(shots, 2))) for c in candidates]
    near = [c for c, w in zip(candidates, worth, strict=True) if w > max(worth) - 2 * ALIAS_WITHIN]
    return near[:MOST_REFITTED]


def in_order(leaders: Sequence[Leader]) -> list[Leader]:
    """Return leaders as they are to be tried: the best first, a believed one before its betters.

    A plausible effect goes first if it has a fifth of the fall of the best.
    """
    ordered = sorted(leaders, key=lambda leader: -leader.criterion)
    if not ordered or ordered[0].plausible:
        return ordered
    least = BELIEVED_SHARE * ordered[0].delta_chi2
    first = [x for x in ordered if x.plausible and x.delta_chi2 > least]
    return [*first, *(x for x in ordered if x not in first)]


def alias_set(chosen: Leader, leaders: Sequence[Leader], ranking: Ranking) -> tuple[str, ...]:
    """Return all effects that these shots cannot tell from the chosen one, it first.

    Those whose refit comes as near as a wrong one would in one campaign of ten, and those that the
    scores foretell to. What a simpler one has fewer parameters for counts in full, ln(shots) each:
    it is not ruled out by luck with more of them. One that contains the chosen effect is no alias
    of it but a larger model.
    """
    delta_chi2 = chosen.unbiased_delta_chi2
    rivals = [c.effect.name for c in ranking.candidates]
    here = rivals.index(chosen.name)
    foretold = dict(zip(rivals, delta_chi2 * (1 - ranking.imitated[here]), strict=True))
    behind = {
        x.name: min(delta_chi2 - x.unbiased_delta_chi2, chosen.criterion - x.criterion)
        for x in leaders
    }
    near = [
        candidate.effect.name
        for candidate in ranking.candidates
        if candidate.effect.name != chosen.name
        and chosen.name not in candidate.effect.contains
        and min(foretold[candidate.effect.name], behind.get(candidate.effect.name, np.inf))
        < ALIAS_WITHIN
    ]
    return (chosen.name, *near)


def _refit(
    data: CampaignData, fit: Fit, candidate: Candidate, bar: float, *, carried: bool
) -> Leader | None:
    """Return a candidate refitted; None where these shots tell nothing of its law.

    It is left where it stands once its expected drop leaves it above a bar.
    """
    if isinstance(candidate.effect, ScatterEffect) and not isinstance(data, ContactTable):
        return _with_scatter(data, fit, candidate, candidate.effect)
    effect = candidate.law or candidate.effect
    data, refit = added(data, fit, effect, Purpose(beat=bar, roughly=True))
    return None if refit is fit else _leader(candidate, data, (fit, refit), carried=carried)


def _leader(
    candidate: Candidate, data: CampaignData, fits: tuple[Fit, Fit], *, carried: bool
) -> Leader:
    """Return what a candidate's refit has come to, from the fits before and with it."""
    (fit, refit), effect = fits, candidate.law or candidate.effect
    count = len(effect.parameters)
    delta_chi2 = fit.chi2 - refit.chi2
    values = refit.theory.vector[-count:]
    sigmas = np.sqrt(np.diag(refit.covariance))[-count:] * np.sqrt(refit.chi2_per_dof)
    freedom = candidate.freedom if candidate.law is None else count - 1
    penalty = freedom * float(np.log(max(len(data.shots), 2)))
    return Leader(
        candidate=candidate,
        data=data,
        fit=refit,
        values=values,
        delta_chi2=delta_chi2,
        criterion=delta_chi2 / max(refit.chi2_per_dof, 1e-12) - penalty,
        plausible=believed(effect, values, sigmas) and _lasts(candidate, values, sigmas),
        carried=carried,
    )


def _lasts(candidate: Candidate, values: Floats, sigmas: Floats) -> bool:
    """Tell whether a contact that lasts has a duration at all; other effects have none."""
    return candidate.law is None or bool(values[0] > DURATION_SIGMAS * sigmas[0])


def _with_scatter(
    data: PoseData | PoseStream, fit: Fit, candidate: Candidate, effect: ScatterEffect
) -> Leader:
    """Fit with the scatter in the noise; its fall is that of the whole likelihood."""
    size, sigma = float(candidate.amplitudes[0]), float(candidate.sigmas[0])
    jittered, refit = with_jitter(data, fit, effect, size, sigma)
    return Leader(
        candidate=candidate,
        data=jittered,
        fit=refit,
        values=candidate.amplitudes,
        delta_chi2=candidate.delta_chi2 * fit.chi2_per_dof,
        criterion=candidate.delta_chi2 - float(np.log(max(len(data.shots), 2))),
        plausible=candidate.plausible,
        carried=False,
    )
