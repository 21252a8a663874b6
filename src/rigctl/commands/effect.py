"""`rigctl effect`: the effects there are, what each is, and a file for one of your own."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from analysis.effects.catalogue import CATALOGUE, LAUNCH_CATALOGUE
from analysis.effects.effect import Effect
from analysis.effects.own import naming
from analysis.effects.own.fault import Fault
from analysis.effects.own.loading import load_effects
from analysis.effects.own.template import template
from analysis.errors import InputError
from rigctl.errors import AnalysisInputError, NotFoundError, SettingsError, StoreError

TABLE_WIDTH = 110
ALL_OF_THE_CATALOGUE: tuple[Effect, ...] = (*CATALOGUE, *LAUNCH_CATALOGUE)
"""Those that poses can show and those of the launch; no name stands twice."""


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
    """Return the effects that poses can show: of the catalogue, and of a folder of the user's.

    Raises
    ------
    AnalysisInputError
        The folder cannot be read, or holds no effect.
    """
    if folder is None:
        return Available(CATALOGUE, ())
    try:
        loaded = load_effects(folder, ALL_OF_THE_CATALOGUE)
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


def new(name: str, *, stage: str, folder: Path) -> Path:
    """Write the file of an effect to fill in; return where it is.

    Raises
    ------
    SettingsError
        The name is taken by the catalogue or not in the form of names, or the file is there.
    StoreError
        The file cannot be written.
    """
    if not naming.well_formed(name):
        raise SettingsError(
            "is not in the form of names", part="NAME", value=repr(name), limit=naming.FORM
        )
    if any(effect.name == name for effect in ALL_OF_THE_CATALOGUE):
        raise SettingsError(
            "the catalogue has an effect of this name", part=name, todo="choose another name"
        )
    path = folder / f"{name}.py"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(template(name, stage))
    except FileExistsError as error:
        raise SettingsError(
            "is there already and is not overwritten",
            part=error.filename or str(path),
            todo="choose another name, or move the file",
        ) from error
    except OSError as error:
        raise StoreError(f"cannot be written: {error.strerror}", part=str(path)) from error
    return path


def listing(folder: Path | None, *, as_json: bool) -> None:
    """Print every effect: its name, the stage it acts in, its parameters and its title.

    Raises
    ------
    AnalysisInputError
        The folder cannot be read, or holds no effect.
    """
    known = _with_launch(available(folder))
    faults = tell(known.faults)
    if as_json:
        _print_json({"effects": [_document(effect) for effect in known.effects], "faults": faults})
        return
    table = Table(box=None)
    table.add_column("effect", no_wrap=True)
    for heading in ("stage", "parameters", "title"):
        table.add_column(heading)
    for effect in known.effects:
        symbols = ", ".join(f"{p.symbol}{_in_unit(p.unit)}" for p in effect.parameters)
        table.add_row(effect.name, effect.stage, symbols, effect.title)
    Console(width=TABLE_WIDTH, markup=False).print(table)


def show(name: str, folder: Path | None, *, as_json: bool) -> None:
    """Print all that an effect says of itself.

    Raises
    ------
    AnalysisInputError
        The folder cannot be read, or the effect of that name has a fault.
    NotFoundError
        No effect has that name.
    """
    known = _with_launch(available(folder))
    effect = known.named(name, "NAME")
    faults = tell(known.faults)
    if as_json:
        _print_json({**_document(effect), "faults": faults})
        return
    console = Console(width=TABLE_WIDTH, markup=False, highlight=False)
    console.print(f"{effect.name}: {effect.title}")
    table = Table(box=None, show_header=False)
    table.add_column(no_wrap=True)
    table.add_column()
    table.add_row("stage", effect.stage)
    for p in effect.parameters:
        low, high = p.plausible
        size = f"plausible {low:g} to {high:g}{_in_unit(p.unit)}, off at {p.off:g}"
        table.add_row(p.symbol, f"{p.meaning}; {size}")
    for heading, text in (
        ("formula", effect.formula),
        ("source", effect.source),
        ("gives away", effect.gives_away),
        ("confused with", ", ".join(effect.confused_with) or "nothing"),
    ):
        table.add_row(heading, text)
    console.print(table)


def _with_launch(known: Available) -> Available:
    return Available((*known.effects, *LAUNCH_CATALOGUE), known.faults)


def _document(effect: Effect) -> dict[str, Any]:
    return {
        "effect": effect.name,
        "title": effect.title,
        "stage": effect.stage,
        "parameters": [
            {
                "symbol": p.symbol,
                "unit": p.unit,
                "meaning": p.meaning,
                "off": p.off,
                "plausible": list(p.plausible),
                "one_sided": p.one_sided,
            }
            for p in effect.parameters
        ],
        "formula": effect.formula,
        "source": effect.source,
        "gives_away": effect.gives_away,
        "confused_with": list(effect.confused_with),
        "variants": [variant.title for variant in effect.variants],
    }


def _in_unit(unit: str) -> str:
    return "" if unit == "1" else f" {unit}"


def _print_json(document: dict[str, Any]) -> None:
    print(json.dumps(document, allow_nan=False))  # noqa: T201
