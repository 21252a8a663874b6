"""Accepted effects weighed once more against all others, now that the rest of them is in.

An effect is accepted while others may still be missing. One that acts more widely then takes part
of what they do and comes before the true one; and what looks alike is another set without them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from analysis.effects.effect import Effect, ScatterEffect
from analysis.model.data.evidence import Stage, stage_of
from analysis.model.data.stream import CampaignData
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.rank.leaders import LATER_LEVEL, Leader, alias_set, in_order, refitted
from analysis.model.rank.ranking import rank

AliasSets = Mapping[str, tuple[str, ...]]


def exchanged(
    data: CampaignData,
    last: Stage,
    effects: Sequence[Effect],
    known: AliasSets,
    without: Mapping[str, Fit],
) -> tuple[Stage, AliasSets]:
    """Exchange each effect for one that does better beside the others, if there is one.

    Parameters
    ----------
    last
        Where all accepted effects are in.
    known
        What looks like each accepted effect, as judged when it was accepted.
    without
        The fit of that stage less each of its effects.

    Returns
    -------
    The stage with the better effects, and what looks like each of them beside the others.
    """
    shifts = [effect for effect in effects if not isinstance(effect, ScatterEffect)]
    alike, first = dict(known), last
    for name in [active.effect.name for active in last.fit.theory.active]:
        rest = without[name] if last is first else _fit_without(data, last.fit, name)
        ranking = rank(data, rest, shifts)
        leaders = refitted(data, rest, ranking, LATER_LEVEL)
        if (best := _better(data, last, name, leaders)) is not None:
            last = stage_of(data, best.fit)
        chosen = best or next((x for x in leaders if x.name == name), None)
        if chosen is not None:
            alike[chosen.name] = alias_set(chosen, leaders, ranking)
    return last, alike


def fits_without(data: CampaignData, fit: Fit) -> dict[str, Fit]:
    """Fit again less each effect."""
    return {a.effect.name: _fit_without(data, fit, a.effect.name) for a in fit.theory.active}


def _fit_without(data: CampaignData, fit: Fit, name: str) -> Fit:
    return fit_campaign(data, fit.theory.without_effect(name), fit)


def _better(data: CampaignData, last: Stage, name: str, leaders: Sequence[Leader]) -> Leader | None:
    """Return the first leader if it is another effect and shots left out agree."""
    first = next(iter(in_order(leaders)), None)
    if first is None or first.name == name or first.carried or not first.fit.converged:
        return None
    return first if stage_of(data, first.fit).error.value < last.error.value else None
