"""`rigctl effect`: the effects there are, what each is, and a file for one of your own."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from analysis.effects.catalogue import LAUNCH_CATALOGUE
from analysis.effects.own import naming
from analysis.effects.own.fault import Fault
from analysis.effects.own.template import template
from rigctl.errors import SettingsError, StoreError
from rigctl.model.known_effects import ALL_EFFECTS, Available, available, effect_document

TABLE_WIDTH = 110


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
    if any(effect.name == name for effect in ALL_EFFECTS):
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
        _print_json(
            {"effects": [effect_document(effect) for effect in known.effects], "faults": faults}
        )
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
        _print_json({**effect_document(effect), "faults": faults})
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


def _in_unit(unit: str) -> str:
    return "" if unit == "1" else f" {unit}"


def _print_json(document: dict[str, Any]) -> None:
    print(json.dumps(document, allow_nan=False))  # noqa: T201
