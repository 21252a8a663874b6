"""Accepted effects weighed once more against all others, now that the rest of them is in.

An effect is accepted while others may still be missing. One that acts more widely then takes part
of what they do and comes before the true one; and what looks alike is another set without them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from analysis.effects.effect import Effect, ScatterEffect
from analysis.model.evidence import Stage, stage_of
from analysis.model.fit import fit_campaign
from analysis.model.leaders import Leader, alias_set, in_order, refitted
from analysis.model.ranking import rank
from analysis.model.tables import Data

AliasSets = Mapping[str, tuple[str, ...]]


def exchanged(
    data: Data, last: Stage, effects: Sequence[Effect], level: float, known: AliasSets
) -> tuple[Stage, AliasSets]:
    """Exchange each effect for one that does better beside the others, if there is one.

    Parameters
    ----------
    last
        Where all accepted effects are in.
    level
        Family-wise level that an effect must pass.
    known
        What looks like each accepted effect, as judged when it was accepted.

    Returns
    -------
    The stage with the better effects, and what looks like each of them beside the others.
    """
    shifts = [effect for effect in effects if not isinstance(effect, ScatterEffect)]
    alike = dict(known)
    for name in [active.effect.name for active in last.fit.theory.active]:
        rest = fit_campaign(data, last.fit.theory.without_effect(name), last.fit)
        ranking = rank(data, rest, shifts)
        leaders = refitted(data, rest, ranking, level)
        if (best := _better(data, last, name, leaders)) is not None:
            last = stage_of(data, best.fit)
        chosen = best or next((x for x in leaders if x.name == name), None)
        if chosen is not None:
            alike[chosen.name] = alias_set(chosen, leaders, ranking)
    return last, alike


def _better(data: Data, last: Stage, name: str, leaders: Sequence[Leader]) -> Leader | None:
    """Return the first leader if it is another effect and shots left out agree."""
    first = next(iter(in_order(leaders)), None)
    if first is None or first.name == name or first.carried or not first.fit.converged:
        return None
    return first if stage_of(data, first.fit).error.value < last.error.value else None
