"""Effects accepted one after the other, what is left ranked anew after each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import ContactLaw, Effect
from analysis.model.data.evidence import Evidence, Stage, stage_of, weighed_again
from analysis.model.fitting.adding import law_again
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.rank.candidate import Ranking
from analysis.model.rank.leaders import (
    FIRST_LEVEL,
    LATER_LEVEL,
    Leader,
    alias_set,
    in_order,
    refitted,
)
from analysis.model.rank.ranking import rank
from analysis.model.structure.far_off import is_far_off
from analysis.model.verdict.exchange import AliasSets

MOST_ACCEPTED, MOST_TRIED = 5, 3
SHADOW = 0.5
"""Share of an effect's expected drop that a better one, not believed, could bring in its stead."""


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """How far a search has come.

    Attributes
    ----------
    path
        From the base model on.
    ranking
        What is asked for beside the effects of its last stage.
    alias_sets
        What looks like each accepted effect, itself first.
    """

    evidence: Evidence
    path: tuple[Stage, ...]
    ranking: Ranking
    alias_sets: AliasSets


def forward(
    found: Found, effects: Sequence[Effect], progress: Callable[[str], None], *, trusting: bool
) -> Found:
    """Accept effects until no leader passes its refit and brings the error left out down.

    Parameters
    ----------
    trusting
        Whether an effect is accepted that two shots carry.
    """
    while len(found.path) <= MOST_ACCEPTED:
        progress(f"refitting the leaders{_beside(found.path[-1].effects)}")
        last, data = found.path[-1], found.evidence.data
        level = FIRST_LEVEL if len(found.path) == 1 else LATER_LEVEL
        leaders = refitted(data, last.fit, found.ranking, level)
        laws = _laws_in(last, effects)
        accepted = _accepted(found, leaders, laws, trusting=trusting)
        if accepted is None:
            break
        leader, stage = accepted
        alike = alias_set(leader, leaders, found.ranking)
        jitter_s = leader.data.jitter_s
        evidence, path, found_law = found.evidence, [*found.path, stage], leader.candidate.law
        if found_law is None:
            evidence, path = weighed_again(evidence, path, jitter_s)
        for law in _laws_in(path[-1], effects):
            again = _law_again(evidence, path, law)
            # A law that is new is judged once it has been looked for in all shots.
            if again is not path or found_law is not None:
                evidence, path = weighed_again(evidence, again, jitter_s)
        ranking = rank(evidence.data, path[-1].fit, effects)
        found = Found(evidence, tuple(path), ranking, {**found.alias_sets, leader.name: alike})
    return found


def _beside(accepted: Sequence[str]) -> str:
    return f" beside {' and '.join(accepted)}" if accepted else ""


def _laws_in(stage: Stage, effects: Sequence[Effect]) -> list[ContactLaw]:
    """Return the law that takes the operator's place, with all its families."""
    return [e for e in effects if isinstance(e, ContactLaw) and e.name in stage.effects]


def _law_again(evidence: Evidence, path: list[Stage], law: ContactLaw) -> list[Stage]:
    """Look for a law once more, in all shots; return the same path where it stays as it is."""
    last = path[-1]
    theory = law_again(evidence, last.fit, law)
    if theory is last.fit.theory:
        return path
    better = stage_of(evidence.data, fit_campaign(evidence.data, theory))
    return [*path[:-1], better]


def _accepted(
    found: Found, leaders: Sequence[Leader], laws: Sequence[ContactLaw], *, trusting: bool
) -> tuple[Leader, Stage] | None:
    """Return the first leader that brings down the error on shots left out, at convergence.

    What two shots carry is passed over, and so is what only stands in for it. A law of contact that
    was found without the leader may hold the fit at a wrong place; where the fit is far off, the
    law is looked for once more beside the leader.
    """
    present, ranking = found.path[-1], found.ranking
    passed = [x for x in in_order(leaders) if x.carried and not trusting]
    believed = [
        x
        for x in in_order(leaders)
        if x.plausible and x not in passed and not _shadow(x, passed, ranking)
    ]
    for leader in believed[:MOST_TRIED]:
        fit = leader.fit
        if not fit.converged:
            fit = fit_campaign(leader.data, fit.theory, fit)
        without = _as_stated(leader, fit) or present
        for stage in _stages(found.evidence, leader, fit, laws):
            if _gains(without, stage, trusting=trusting):
                return leader, stage
    return None


def _stages(
    evidence: Evidence, leader: Leader, fit: Fit, laws: Sequence[ContactLaw]
) -> Iterator[Stage]:
    """Yield a leader's stage as fitted, and, where it is far off, with laws looked for anew."""
    yield (begun := stage_of(leader.data, fit))
    if is_far_off(begun.fit):
        for law in laws:
            theory = law_again(evidence, fit, law)
            if theory is not fit.theory:
                yield stage_of(leader.data, fit_campaign(leader.data, theory))


def _as_stated(leader: Leader, fit: Fit) -> Stage | None:
    """Return the stage with the air just as stated; None: the leader is another effect.

    What is stated with an error followed the shots before, nearly as far as they pull it now, so
    that those left out hardly gain. What they must speak against is the stated size.
    """
    if leader.candidate.weight == 1.0:
        return None
    theory = fit.theory.as_stated(leader.name)
    return stage_of(leader.data, fit_campaign(leader.data, theory, fit))


def _gains(present: Stage, stage: Stage, *, trusting: bool) -> bool:
    """Tell whether shots left out are predicted better, and most of them.

    Where the present fit is far off, noise is no measure of what single shots gain: one that is
    predicted worse by a bent law would outweigh all others. Ratios of their errors count there.
    """
    before, after = present.error.by_shot, stage.error.by_shot
    gains = before - after
    if is_far_off(present.fit):
        gains = np.log(np.maximum(before, 1.0) / np.maximum(after, 1.0))
    delta_chi2 = (present.fit.chi2 - stage.fit.chi2) / max(stage.fit.chi2_per_dof, 1e-12)
    return float(gains.sum()) > 0.0 and (trusting or is_shared(gains, delta_chi2))


def _shadow(leader: Leader, passed: Sequence[Leader], ranking: Ranking) -> bool:
    """Whether a better effect that was passed over could bring most of what this one does."""
    names = [candidate.effect.name for candidate in ranking.candidates]
    own = ranking.imitated[names.index(leader.name)]
    return any(x.criterion > leader.criterion and own[names.index(x.name)] > SHADOW for x in passed)


MOST_ASKED = 3.0
ALLOWED = 2.0
"""Standard deviations by which a real effect may fall below what its score lets expect."""
OF_ATTAINABLE = 0.5
"""Of few shots even gains in all of them add up to little: 2.8 for ten."""
BEST, STRONG = 2, 36.0
"""A fall of six standard errors and more must be there without the two shots that gain most."""


def signed_rank(gains: Floats) -> float:
    """Return sum sign(D) rank|D| / sqrt(sum rank^2) of gains D, shape (S,).

    Near a unit normal where gains and losses are alike; 0 without any.
    """
    ranks = ranks_of(np.abs(gains)) * (gains != 0)
    size = float(np.sqrt((ranks**2).sum()))
    return float((np.sign(gains) * ranks).sum() / size) if size > 0 else 0.0


def ranks_of(values: Floats) -> Floats:
    """Return the rank of each number, from 1, shape (S,); equal ones share their mean rank."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - (count - 1) / 2)[place]


def is_shared(gains: Floats, delta_chi2: float) -> bool:
    """Tell whether the shots share a gain, given the fall of chi-squared in units of the noise.

    A real effect lowers the error of most shots in which it acts; a chance one, or one that stands
    in for an error of some shots, that of few. F. Wilcoxon's signed ranks of the gains tell them
    apart: an effect of score d, spread over many shots, has a sum of signed ranks of about d / 2
    standard deviations.

    Parameters
    ----------
    gains
        By how much the whitened squares of each shot left out fall, shape (S,).
    """
    attainable = signed_rank(np.arange(1.0, len(gains) + 1.0))
    expected = 0.5 * float(np.sqrt(max(delta_chi2, 0.0))) - ALLOWED
    asked = min(expected, MOST_ASKED, OF_ATTAINABLE * attainable)
    rest = np.sort(gains)[:-BEST] if len(gains) > 2 * BEST and delta_chi2 > STRONG else gains
    return signed_rank(gains) > asked and float(rest.sum()) > 0
