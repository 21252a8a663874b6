"""`rigctl effect`: the effects there are, what each is, and a file for one of your own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import Effect
from analysis.effects.own.fault import Fault
from analysis.effects.own.loading import load_effects
from analysis.errors import InputError
from rigctl.errors import AnalysisInputError, NotFoundError


@dataclass(frozen=True, slots=True)
class Available:
    """The effects of the catalogue and of a folder, and the faults of those that are of no use."""

    effects: tuple[Effect, ...]
    faults: tuple[Fault, ...]

    def named(self, name: str, part: str) -> Effect:
        """Return the effect of a name.

        Raises
        ------
        AnalysisInputError
            The effect of that name has a fault.
        NotFoundError
            There is none of that name.
        """
        known = {effect.name: effect for effect in self.effects}
        if name in known:
            return known[name]
        for fault in self.faults:
            if fault.effect == name:
                raise refused(fault)
        raise NotFoundError(
            "no effect of the catalogue has this name",
            part=part,
            value=repr(name),
            todo=f"choose one of {', '.join(sorted(known))}",
        )


def available(folder: Path | None) -> Available:
    """Return the effects of the catalogue and, beside it, of a folder of the user's.

    Raises
    ------
    AnalysisInputError
        The folder cannot be read, or holds no effect.
    """
    if folder is None:
        return Available(CATALOGUE, ())
    try:
        loaded = load_effects(folder, CATALOGUE)
    except InputError as error:
        raise AnalysisInputError(error.reason, part=f"--effects {error.path}") from error
    return Available((*CATALOGUE, *loaded.effects), loaded.faults)


def refused(fault: Fault) -> AnalysisInputError:
    """Return the error of a command that needs the effect that has a fault."""
    return AnalysisInputError(
        f"{fault.effect}: {fault.what}", part=f"{fault.path}, line {fault.line}", todo=fault.todo
    )


def tell(faults: Sequence[Fault]) -> list[dict[str, Any]]:
    """Say each fault on standard error, and return all as a document has them."""
    console = Console(stderr=True, soft_wrap=True, markup=False, highlight=False)
    for fault in faults:
        console.print(f"rigctl: left out: {fault.sentence()}")
    return [fault.to_json() for fault in faults]
