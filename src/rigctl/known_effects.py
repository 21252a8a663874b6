"""The effects there are, by their names."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.effects.catalogue import CATALOGUE, LAUNCH_CATALOGUE
from analysis.effects.effect import Effect
from rigctl.errors import NotFoundError

ALL_EFFECTS: tuple[Effect, ...] = (*CATALOGUE, *LAUNCH_CATALOGUE)
"""Those that poses can show, and those of the launch."""


def effect_named(name: str, effects: Sequence[Effect] = CATALOGUE) -> Effect:
    """Return an effect; `NotFoundError`, if there is none of that name, lists those there are."""
    known = {effect.name: effect for effect in effects}
    if name not in known:
        raise NotFoundError(
            "no effect of the catalogue has this name",
            value=repr(name),
            todo=f"choose one of {', '.join(sorted(known))}",
        )
    return known[name]
