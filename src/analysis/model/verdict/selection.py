"""From scores to a verdict: which effects are missing, or none, or one that no catalogue holds.

Forward with re-ranking, one backward pass, then the lack-of-fit test. An effect is accepted when
its refit passes the family-wise level, no two shots carry it, and the error on shots left out
falls.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis import chi_squared
from analysis.effects.clock.timing_jitter import EFFECT as JITTER
from analysis.effects.effect import Effect
from analysis.model.data.evidence import Stage, stage_of, weighed
from analysis.model.data.inside import without_contact_frames
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.air import with_measured_air
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.outliers import Cleaned
from analysis.model.fitting.slow_errors.sizes import with_measured_slow_errors
from analysis.model.rank.candidate import Ranking, weight_of
from analysis.model.rank.ranking import rank
from analysis.model.structure.alarm import UNEXPLAINED_LEVEL, alarms, is_short
from analysis.model.structure.far_off import is_far_off
from analysis.model.structure.lackoffit import Cell, lack_of_fit
from analysis.model.verdict.exchange import AliasSets, exchanged, fits_without
from analysis.model.verdict.forward import Found, forward
from analysis.model.verdict.part import what_explains
from analysis.schema.verdict import TornTrack, Verdicts

DROP_LEVEL = 0.0005


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
    torn
        Shot number, sphere, first and last frame of what was cut of tracks that leave free flight.
    noise
        By what stated sigmas of positions and orientations were multiplied; 1: as stated.
    """

    verdict: Verdicts
    effects: tuple[str, ...]
    alias_sets: Mapping[str, tuple[str, ...]]
    path: tuple[Stage, ...]
    ranking: Ranking
    first_ranking: Ranking
    cells: tuple[Cell, ...]
    cleaned: Cleaned
    noise: tuple[float, float]
    torn: tuple[TornTrack, ...] = ()

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
    data: CampaignData,
    effects: Sequence[Effect],
    progress: Callable[[str], None] = lambda _: None,
) -> Verdict:
    """Go the whole way from the base model to a verdict.

    Beside `unexplained` stand only effects without which shots left out would be foretold worse.
    """
    found = _concluded(data, effects, progress)
    return _honest(found, effects) if found.verdict == "unexplained" else found


def _honest(found: Verdict, effects: Sequence[Effect]) -> Verdict:
    """Return an unexplained verdict without the effects that explain nothing."""
    path = what_explains(found.cleaned.data, found.path)
    if len(path) == len(found.path):
        return found
    names = path[-1].effects
    return replace(
        found,
        effects=names,
        alias_sets={name: found.alias_sets[name] for name in names},
        path=path,
        ranking=rank(found.cleaned.data, path[-1].fit, effects),
    )


def _concluded(
    data: CampaignData, effects: Sequence[Effect], progress: Callable[[str], None]
) -> Verdict:
    """Accept effects step by step, and judge what is left."""
    progress("fitting the base model")
    stated = with_measured_slow_errors(with_measured_air(without_contact_frames(data)))
    evidence = weighed(stated)
    base = stage_of(evidence.data, evidence.cleaned.fit)
    first_ranking = rank(evidence.data, base.fit, effects)
    start = Found(evidence, (base,), first_ranking, {})
    found = _searched(start, effects, progress, trusting=False)
    progress("testing what is left")
    cells = _left(found)
    if _alarmed(found, cells):
        # Structure that is there for sure may be believed to be what two shots show most.
        again = _searched(found, effects, progress, trusting=True)
        if len(again.path) > len(found.path) and not _alarmed(again, quiet := _left(again)):
            found, cells = again, quiet
    names = found.path[-1].effects
    alias_sets, last = {name: found.alias_sets[name] for name in names}, found.path[-1]
    short = bool(names) and is_short(cells, len(found.evidence.data.shots), last.error.value)
    left = short or _alarmed(found, cells) or is_far_off(last.fit)
    return Verdict(
        verdict="unexplained" if left else _word(alias_sets),
        effects=names,
        alias_sets=alias_sets,
        path=found.path,
        ranking=found.ranking,
        first_ranking=first_ranking,
        cells=cells,
        cleaned=found.evidence.cleaned,
        noise=found.evidence.noise,
        torn=() if isinstance(stated, ContactTable) else stated.torn,
    )


def _searched(
    start: Found, effects: Sequence[Effect], progress: Callable[[str], None], *, trusting: bool
) -> Found:
    """Go forward, drop what has become superfluous, and weigh the rest beside each other."""
    found = forward(start, effects, progress, trusting=trusting)
    data = found.evidence.data
    path, without = _backward(data, list(found.path))
    last, alike = path[-1], found.alias_sets
    if without:
        progress("weighing accepted effects beside each other")
        last, alike = exchanged(data, last, effects, alike, without)
    if last is found.path[-1]:
        return replace(found, alias_sets=alike)
    path = path if last is path[-1] else [*path, last]
    return Found(found.evidence, tuple(path), rank(data, last.fit, effects), alike)


def _left(found: Found) -> tuple[Cell, ...]:
    """Return the structure that is left."""
    last = found.path[-1]
    return _unmasked(found.path, lack_of_fit(found.evidence.data, last.fit), found.evidence.data)


def _alarmed(found: Found, cells: Sequence[Cell]) -> bool:
    return any(alarms(cell, len(found.evidence.data.shots)) for cell in cells)


def _word(alias_sets: AliasSets) -> Verdicts:
    if not alias_sets:
        return "none"
    return "alias" if any(len(alike) > 1 for alike in alias_sets.values()) else "effect"


def _unmasked(
    path: Sequence[Stage], cells: tuple[Cell, ...], data: CampaignData
) -> tuple[Cell, ...]:
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


def _backward(data: CampaignData, path: list[Stage]) -> tuple[list[Stage], dict[str, Fit]]:
    """Drop, worst first, whatever the effects accepted after it have made superfluous.

    Returns
    -------
    The path, and the fit of its last stage less each of several effects; a single one stays.
    """
    last, without = path[-1], dict[str, Fit]()
    while len(active := last.fit.theory.active) > 1:
        without = fits_without(data, last.fit)
        losses = np.array([fit.chi2 - last.fit.chi2 for fit in without.values()])
        sizes = np.array([len(a.values) for a in active])
        weights = np.array([weight_of(a.effect, stated=bool(a.freed)) for a in active])
        p_values = chi_squared.chance_of_more(losses / last.fit.chi2_per_dof, sizes) / weights
        worst = int(p_values.argmax())
        if p_values[worst] < DROP_LEVEL:
            return path, without
        last = stage_of(data, without[active[worst].effect.name])
        path = [*path, last]
    return path, {}
