"""From scores to a verdict: which effect is missing, or that none is, or that none is known.

Forward selection with ranking anew after each acceptance, one backward pass, and the test for
structure that remains. A score only invites an effect to be fitted; it is accepted when its refit
beats, at the level corrected for having looked at all, what chance can do, and when the error on
shots left out falls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2 as chi2_distribution

from analysis.effects.effect import Effect
from analysis.model.crossvalidation import PredictionError, prediction_error
from analysis.model.fit import Fit, fit_campaign
from analysis.model.inside import without_contact_frames
from analysis.model.lackoffit import Cell, lack_of_fit
from analysis.model.outliers import Cleaned, clean
from analysis.model.poses import PoseData
from analysis.model.ranking import Candidate, Ranking, rank

FIRST_LEVEL, LATER_LEVEL = 0.03, 0.01
"""Family-wise level of the first acceptance and of each later one: the stricter keeps out shadows
of an effect already accepted."""
MOST_ACCEPTED, MOST_REFITTED = 5, 10
ALIAS_WITHIN = (2 * 1.2816) ** 2
"""Refits this close in deviance are told apart rightly in less than nine of ten campaigns."""
BELIEVED_SHARE = 0.2
"""A plausible effect goes before an implausible one if it has this share of its fall."""
DROP_LEVEL = 0.0015
UNEXPLAINED_LEVEL = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Leader:
    """A refitted candidate: the fall of chi-squared it really brought, and the fit."""

    candidate: Candidate
    fit: Fit
    fall: float
    criterion: float
    plausible: bool


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """One point of the error path: the effects in, the fit, and the error on shots left out."""

    effects: tuple[str, ...]
    fit: Fit
    error: PredictionError


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What is concluded.

    Attributes
    ----------
    verdict
        none, effect, alias or unexplained.
    effects
        Names of the accepted effects; when unexplained, what explains part.
    alias_set
        All that these shots cannot tell from an accepted effect, itself first: of the first that
        has company, else of the first.
    path
        From the base model on.
    ranking
        What the data ask for at the end.
    cells
        Structure that is left, the most striking first.
    data, cleaned
        What was used, and what was taken out.
    """

    verdict: str
    effects: tuple[str, ...]
    alias_set: tuple[str, ...]
    path: tuple[Stage, ...]
    ranking: Ranking
    first_ranking: Ranking
    cells: tuple[Cell, ...]
    cleaned: Cleaned

    @property
    def fit(self) -> Fit:
        """The fit with everything accepted."""
        return self.path[-1].fit


def explain(
    data: PoseData,
    effects: Sequence[Effect],
    progress: Callable[[str], None] = lambda _: None,
) -> Verdict:
    """Go the whole way from the base model to a verdict."""
    progress("fitting the base model")
    cleaned = clean(without_contact_frames(data))
    used = cleaned.data
    path = [_stage(used, cleaned.fit)]
    first_ranking = ranking = rank(used, cleaned.fit, effects)
    alias_sets: dict[str, tuple[str, ...]] = {}
    while len(path) <= MOST_ACCEPTED:
        progress(f"refitting the leaders, {len(path) - 1} effects accepted")
        level = FIRST_LEVEL if len(path) == 1 else LATER_LEVEL
        leaders = _leaders(used, path[-1].fit, ranking, level)
        chosen = _choose(leaders)
        if chosen is None:
            break
        stage = _stage(used, fit_campaign(used, chosen.fit.theory, chosen.fit))
        if stage.error.value >= path[-1].error.value:
            break
        name = chosen.candidate.effect.name
        alias_sets[name] = _alias_set(chosen, leaders)
        path.append(stage)
        ranking = rank(used, stage.fit, effects)
    path = _backward(used, path)
    accepted = path[-1].effects
    progress("testing what is left")
    cells = lack_of_fit(used, path[-1].fit)
    ambiguous = [name for name in accepted if len(alias_sets[name]) > 1]
    alias_set = next((alias_sets[name] for name in (*ambiguous, *accepted)), ())
    return Verdict(
        verdict=_word(accepted, alias_sets, cells),
        effects=accepted,
        alias_set=alias_set,
        path=tuple(path),
        ranking=ranking,
        first_ranking=first_ranking,
        cells=cells,
        cleaned=cleaned,
    )


def _word(
    accepted: tuple[str, ...], alias_sets: dict[str, tuple[str, ...]], cells: tuple[Cell, ...]
) -> str:
    if cells and cells[0].p_holm < UNEXPLAINED_LEVEL:
        return "unexplained"
    if not accepted:
        return "none"
    return "alias" if any(len(alias_sets[name]) > 1 for name in accepted) else "effect"


def _stage(data: PoseData, fit: Fit) -> Stage:
    names = tuple(active.effect.name for active in fit.theory.active)
    return Stage(names, fit, prediction_error(data, fit))


def _leaders(data: PoseData, fit: Fit, ranking: Ranking, level: float) -> list[Leader]:
    """Refit every candidate whose promise passes the level, at most ten."""
    invited = [c for c in ranking.candidates if c.seen and c.p_familywise < level]
    leaders = []
    for candidate in invited[:MOST_REFITTED]:
        refit = fit_campaign(data, fit.theory.with_effect(candidate.effect), fit)
        leaders.append(_leader(candidate, refit, fit, len(data.shots)))
    if not leaders:
        return []
    noise = min(leader.fit.chi2_per_dof for leader in leaders)
    threshold = max(c.p_value for c in invited)
    return [
        leader
        for leader in leaders
        if chi2_distribution.sf(leader.fall / noise, len(leader.candidate.amplitudes)) <= threshold
    ]


def _leader(candidate: Candidate, refit: Fit, fit: Fit, shots: int) -> Leader:
    fall = fit.chi2 - refit.chi2
    count = len(candidate.effect.parameters)
    values = refit.theory.vector[-count:]
    sigmas = np.sqrt(np.diag(refit.covariance))[-count:]
    return Leader(
        candidate=candidate,
        fit=refit,
        fall=fall,
        criterion=fall / max(refit.chi2_per_dof, 1e-12) - count * float(np.log(max(shots, 2))),
        plausible=_believed(candidate.effect, values, sigmas),
    )


def _believed(effect: Effect, values: NDArray[np.float64], sigmas: NDArray[np.float64]) -> bool:
    return all(
        parameter.plausible[0] - 2 * sigma <= value <= parameter.plausible[1] + 2 * sigma
        for parameter, value, sigma in zip(effect.parameters, values, sigmas, strict=True)
    )


def _choose(leaders: list[Leader]) -> Leader | None:
    """Return the best refit; a plausible one before a better one that is not believed."""
    if not leaders:
        return None
    best = max(leaders, key=lambda leader: leader.criterion)
    if best.plausible:
        return best
    believed = [x for x in leaders if x.plausible and x.fall > BELIEVED_SHARE * best.fall]
    return max(believed, key=lambda leader: leader.criterion, default=best)


def _alias_set(chosen: Leader, leaders: list[Leader]) -> tuple[str, ...]:
    """Return all refits that these shots cannot tell from the chosen one, it first.

    One that contains the chosen effect is no alias of it but a larger model.
    """
    name = chosen.candidate.effect.name
    near = [
        leader.candidate.effect.name
        for leader in leaders
        if leader is not chosen
        and abs(chosen.criterion - leader.criterion) < ALIAS_WITHIN
        and len(leader.candidate.amplitudes) <= len(chosen.candidate.amplitudes)
    ]
    return (name, *near)


def _backward(data: PoseData, path: list[Stage]) -> list[Stage]:
    """Drop, worst first, whatever the effects accepted after it have made superfluous."""
    last = path[-1]
    while len(last.effects) > 1:
        without = [
            fit_campaign(data, last.fit.theory.without_effect(name), last.fit)
            for name in last.effects
        ]
        losses = np.array([fit.chi2 - last.fit.chi2 for fit in without]) / last.fit.chi2_per_dof
        sizes = np.array([len(active.values) for active in last.fit.theory.active])
        p_values = np.asarray(chi2_distribution.sf(losses, sizes))
        worst = int(p_values.argmax())
        if p_values[worst] < DROP_LEVEL:
            break
        last = _stage(data, without[worst])
        path = [*path, last]
    return path
