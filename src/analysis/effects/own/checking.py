"""An effect tried before it is used: what it declares, and how it behaves on a few shots."""

from __future__ import annotations

from pathlib import Path

from analysis.effects.effect import Effect
from analysis.effects.own.declaration import complaint
from analysis.effects.own.fault import EffectFault, Fault


def check(effect: Effect, path: Path, line: int) -> None:
    """See whether an effect can be fitted and ranked.

    Parameters
    ----------
    path, line
        Where it is defined.

    Raises
    ------
    EffectFault
        It cannot; the first reason found.
    """
    if found := complaint(effect):
        raise EffectFault(Fault(path, line, str(effect.name), *found))
