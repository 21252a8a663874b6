"""An effect tried before it is used: what it declares, and how it behaves on a few shots."""

from __future__ import annotations

from pathlib import Path

from analysis.effects.effect import Effect
from analysis.effects.own import behaviour, declaration
from analysis.effects.own.fault import EffectFault, Fault
from analysis.effects.own.guard import function_line, function_of, guarded
from analysis.effects.own.numbers import has_own_numbers


def checked(effect: Effect, path: Path, line: int) -> Effect:
    """Return an effect that can be fitted and ranked, under watch.

    Parameters
    ----------
    path, line
        Where it is defined.

    Raises
    ------
    EffectFault
        It cannot; the first reason found. What it declares is named at its definition, what it
        does at its function.
    """
    if found := declaration.complaint(effect):
        raise EffectFault(Fault(path, line, str(effect.name), *found))
    watched = guarded(effect, path, line)
    for mine, tried in zip((effect, *effect.variants), (watched, *watched.variants), strict=True):
        function = function_of(mine)
        found = behaviour.complaint(tried, has_own_numbers=has_own_numbers(function))
        if found:
            place = function_line(path, function) or line
            raise EffectFault(Fault(path, place, effect.name, *found))
    return watched
