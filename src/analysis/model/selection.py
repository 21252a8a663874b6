"""From scores to a verdict: which effects are missing, or none, or one that no catalogue holds.

Forward with re-ranking, one backward pass, then the lack-of-fit test. An effect is accepted when
its refit passes the family-wise level, no two shots carry it, and the error on shots left out
falls.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2 as chi2_distribution

from analysis.effects.effect import Effect
from analysis.effects.timing_jitter import EFFECT as JITTER
from analysis.model.evidence import Stage, stage_of, weighed, weighed_again
from analysis.model.exchange import AliasSets, exchanged
from analysis.model.fit import Fit, fit_campaign
from analysis.model.inside import without_contact_frames
from analysis.model.lackoffit import Cell, lack_of_fit
from analysis.model.leaders import Leader, alias_set, in_order, most_carried, refitted
from analysis.model.outliers import Cleaned
from analysis.model.ranking import Ranking, rank
from analysis.model.tables import Data

FIRST_LEVEL, LATER_LEVEL = 0.03, 0.01
"""Family-wise level of the first acceptance and of each later one: the stricter keeps out shadows
of an effect already accepted."""
MOST_ACCEPTED, MOST_TRIED = 5, 3
DROP_LEVEL = 0.0015
UNEXPLAINED_LEVEL = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What is concluded.

    Attributes
    ----------
    verdict
        none, effect, alias or unexplained.
    effects
        Names of the accepted effects; when unexplained, what explains part.
    alias_sets
        All that these shots cannot tell from each accepted effect, itself first.
    path
        From the base model on.
    ranking
        What the data ask for at the end.
    cells
        Structure that is left, the most striking first; among it what stood where an effect shows
        most, if it would explain more than the effects that silenced it.
    cleaned
        What was used, and what was taken out.
    noise
        By what stated sigmas of positions and orientations were multiplied; 1: as stated.
    """

    verdict: str
    effects: tuple[str, ...]
    alias_sets: Mapping[str, tuple[str, ...]]
    path: tuple[Stage, ...]
    ranking: Ranking
    first_ranking: Ranking
    cells: tuple[Cell, ...]
    cleaned: Cleaned
    noise: tuple[float, float]

    @property
    def alias_set(self) -> tuple[str, ...]:
        """All that may be meant: the sets of the effects that have company, else of the first."""
        sets = [self.alias_sets[name] for name in self.effects]
        ambiguous = [alike for alike in sets if len(alike) > 1] or sets[:1]
        return tuple(dict.fromkeys(name for alike in ambiguous for name in alike))

    @property
    def fit(self) -> Fit:
        """The fit with everything accepted."""
        return self.path[-1].fit


def explain(
    data: Data,
    effects: Sequence[Effect],
    progress: Callable[[str], None] = lambda _: None,
) -> Verdict:
    """Go the whole way from the base model to a verdict."""
    progress("fitting the base model")
    evidence = weighed(without_contact_frames(data))
    path = [stage_of(evidence.data, evidence.cleaned.fit)]
    first_ranking = ranking = rank(evidence.data, path[-1].fit, effects)
    alias_sets: AliasSets = {}
    while len(path) <= MOST_ACCEPTED:
        progress(f"refitting the leaders, {len(path) - 1} effects accepted")
        level = FIRST_LEVEL if len(path) == 1 else LATER_LEVEL
        leaders = refitted(evidence.data, path[-1].fit, ranking, level)
        accepted = _accepted(path[-1], leaders)
        if accepted is None:
            break
        leader, stage = accepted
        alias_sets = {**alias_sets, leader.name: alias_set(leader, leaders, ranking)}
        evidence, path = weighed_again(evidence, [*path, stage], leader.data.jitter_s)
        ranking = rank(evidence.data, path[-1].fit, effects)
    path = _backward(evidence.data, path)
    if len(path[-1].fit.theory.active) > 1:
        progress("weighing accepted effects against the others")
        last, alias_sets = exchanged(evidence.data, path[-1], effects, LATER_LEVEL, alias_sets)
        path = path if last is path[-1] else [*path, last]
    progress("testing what is left")
    cells = _unmasked(path, lack_of_fit(evidence.data, path[-1].fit), evidence.data)
    names = path[-1].effects
    return Verdict(
        verdict=_word(names, alias_sets, cells, most_carried(len(evidence.data.shots))),
        effects=names,
        alias_sets={name: alias_sets[name] for name in names},
        path=tuple(path),
        ranking=ranking,
        first_ranking=first_ranking,
        cells=cells,
        cleaned=evidence.cleaned,
        noise=evidence.noise,
    )


def _accepted(present: Stage, leaders: Sequence[Leader]) -> tuple[Leader, Stage] | None:
    """Return the first leader that brings down the error on shots left out, at convergence."""
    for leader in in_order(leaders)[:MOST_TRIED]:
        fit = leader.fit
        if not fit.converged:
            fit = fit_campaign(leader.data, fit.theory, fit)
        stage = stage_of(leader.data, fit)
        if stage.error.value < present.error.value:
            return leader, stage
    return None


def _word(
    accepted: tuple[str, ...],
    alias_sets: AliasSets,
    cells: tuple[Cell, ...],
    carried: float,
) -> str:
    if any(_alarms(cell, carried) for cell in cells):
        return "unexplained"
    if not accepted:
        return "none"
    return "alias" if any(len(alias_sets[name]) > 1 for name in accepted) else "effect"


def _alarms(cell: Cell, carried: float) -> bool:
    """Whether a cell stands out, and not by the word of two shots alone."""
    believed = cell.carried_share < carried or cell.p_rest < UNEXPLAINED_LEVEL
    return cell.p_holm < UNEXPLAINED_LEVEL and believed


def _unmasked(path: Sequence[Stage], cells: tuple[Cell, ...], data: Data) -> tuple[Cell, ...]:
    """Put back the alarm of an effect's own cell that explains more than all effects put in later.

    One cause that no catalogue has is likelier than several of it whose marks happen to add up
    where the first of them shows.
    """
    last = path[-1]
    names, noise = set(last.effects), max(last.fit.chi2_per_dof, 1e-12)
    found = {(cell.channel, cell.covariate): cell for cell in cells}
    for stage in path[1:-1]:
        if not set(stage.effects) < names or JITTER.name in names:
            continue
        count = len(last.fit.theory.names) - len(stage.fit.theory.names)
        gained = (stage.fit.chi2 - last.fit.chi2) / noise - count
        unit = stage.fit.chi2_per_dof / noise
        for cell in lack_of_fit(data, stage.fit):
            alarmed = cell.own_of and cell.p_holm < UNEXPLAINED_LEVEL
            if alarmed and unit * cell.chi2 - cell.freedom > gained:
                found[cell.channel, cell.covariate] = cell
    return tuple(sorted(found.values(), key=lambda cell: (cell.p_value, -cell.chi2)))


def _backward(data: Data, path: list[Stage]) -> list[Stage]:
    """Drop, worst first, whatever the effects accepted after it have made superfluous."""
    last = path[-1]
    while len(last.fit.theory.active) > 1:
        active = last.fit.theory.active
        without = [
            fit_campaign(data, last.fit.theory.without_effect(a.effect.name), last.fit)
            for a in active
        ]
        losses = np.array([fit.chi2 - last.fit.chi2 for fit in without]) / last.fit.chi2_per_dof
        sizes = np.array([len(a.values) for a in active])
        p_values = np.asarray(chi2_distribution.sf(losses, sizes))
        worst = int(p_values.argmax())
        if p_values[worst] < DROP_LEVEL:
            break
        last = stage_of(data, without[worst])
        path = [*path, last]
    return path
