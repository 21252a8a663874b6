"""The candidate effects of a campaign: those of the catalogue and the user's own."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import Effect
from analysis.effects.own.checking import checked
from analysis.effects.own.dropping import without_faulty
from analysis.effects.own.fault import Fault
from analysis.effects.own.guard import FUNCTIONS, function_of
from rigctl.errors import AnalysisInputError
from rigctl.model.known_effects import ALL_EFFECTS, Available, available, faults_refused

Given = str | Path | Effect
"""An effect: its name, the file that defines it, or the effect itself."""
Result = TypeVar("Result")


def effects(own: str | Path | None = None) -> Mapping[str, Effect]:
    """Return all effects that poses can show, by name.

    Parameters
    ----------
    own
        Folder or file of effects of one's own, to be among them. It is run.

    Raises
    ------
    AnalysisInputError
        It cannot be read, or holds no effect.
    """
    return {effect.name: effect for effect in KnownEffects.of(own).effects}


class KnownEffects:
    """The effects there are; one with a fault is named in a warning, and left out."""

    def __init__(self, known: Available) -> None:
        self._known = known

    @classmethod
    def of(cls, own: str | Path | Sequence[Effect] | None) -> KnownEffects:
        """Return the catalogue, with those of a folder, of a file, or such as are handed in."""
        if own is None or isinstance(own, str | Path):
            known = available(None if own is None else Path(own), part="effects")
            _warn(known.faults)
            return cls(known)
        with faults_refused():
            added = tuple(_watched(effect) for effect in own)
        return cls(Available((*CATALOGUE, *added), ()))

    @property
    def effects(self) -> tuple[Effect, ...]:
        """All of them."""
        return self._known.effects

    def chosen(self, given: Given) -> Effect:
        """Return one effect, ready to be fitted.

        Raises
        ------
        AnalysisInputError
            It has a fault.
        NotFoundError
            None has that name.
        """
        if isinstance(given, Effect):
            if any(given is effect for effect in self.effects):
                return given
            with faults_refused():
                return _watched(given)
        if isinstance(given, Path) or given.endswith(".py"):
            found = available(Path(given), part="effect")
            name = next(iter(found.files), None) or found.faults[0].effect
            return found.named(name, "effect")
        return self._known.named(given, "effect")

    def all_in(self, compute: Callable[[Sequence[Effect]], Result]) -> Result:
        """Compute with all effects, without those that fail in it."""
        with faults_refused():
            result, dropped = without_faulty(self.effects, compute)
        _warn(dropped)
        return result


def _watched(effect: Effect) -> Effect:
    """Return an effect of a notebook or a script, tried as that of a file is."""
    if any(effect.name == known.name for known in ALL_EFFECTS):
        raise AnalysisInputError(
            "has the name of an effect of the catalogue",
            part=str(effect.name),
            todo="give it another name",
        )
    if effect.stage not in FUNCTIONS:
        raise AnalysisInputError(
            "acts where poses do not show it",
            part=str(effect.name),
            value=effect.stage,
            limit=", ".join(FUNCTIONS),
        )
    code = getattr(function_of(effect), "__code__", None)
    path, line = ("notebook", 1) if code is None else (code.co_filename, code.co_firstlineno)
    return checked(effect, Path(path), line)


def _warn(faults: Sequence[Fault]) -> None:
    for fault in faults:
        warnings.warn(f"left out: {fault.sentence()}", stacklevel=4)
