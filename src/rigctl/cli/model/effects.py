"""`rigctl effect`: the effects there are, what each is, and a file for one of your own."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from analysis.effects.catalogue import LAUNCH_CATALOGUE
from analysis.effects.own.template import FORM, template, well_formed
from rigctl.cli.model.reading import report_faults
from rigctl.cli.options import Json, OwnEffects
from rigctl.cli.output import TABLE_WIDTH, print_json
from rigctl.errors import SettingsError, StoreError
from rigctl.model.known_effects import ALL_EFFECTS, Available, available, effect_document


class EffectStage(StrEnum):
    """Where on the way from contact to image an effect acts."""

    CONTACT = "contact"
    FLIGHT = "flight"
    CAMERA = "camera"
    CLOCK = "clock"


def new(
    name: Annotated[str, typer.Argument(help="Its name: lower case, words joined by hyphens.")],
    *,
    stage: Annotated[EffectStage, typer.Option(help="Where it acts.")] = EffectStage.CONTACT,
    folder: Annotated[Path, typer.Option(help="Folder the file is written to.")] = Path("effects"),
) -> None:
    """Write the file of an effect to fill in.

    Raises
    ------
    SettingsError
        The name is taken by the catalogue or not in the form of names, or the file is there.
    StoreError
        The file cannot be written.
    """
    if not well_formed(name):
        raise SettingsError(
            "is not in the form of names", part="NAME", value=repr(name), limit=FORM
        )
    if any(effect.name == name for effect in ALL_EFFECTS):
        raise SettingsError(
            "the catalogue has an effect of this name", part=name, todo="choose another name"
        )
    path = folder / f"{name}.py"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(template(name, stage.value))
    except FileExistsError as error:
        raise SettingsError(
            "is there already and is not overwritten",
            part=error.filename or str(path),
            todo="choose another name, or move the file",
        ) from error
    except OSError as error:
        raise StoreError(f"cannot be written: {error.strerror}", part=str(path)) from error
    typer.echo(f"{path}: fill it in, then rigctl model rank CAMPAIGN --effects {folder}")


def list_effects(*, folder: OwnEffects = None, json: Json = False) -> None:
    """Print every effect: its name, the stage it acts in, its parameters and its title.

    Raises
    ------
    AnalysisInputError
        The folder cannot be read, or holds no effect.
    """
    known = _with_launch(available(folder))
    faults = report_faults(known.faults)
    if json:
        print_json(
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


def show(
    name: Annotated[str, typer.Argument(help="Name of the effect.")],
    *,
    folder: OwnEffects = None,
    json: Json = False,
) -> None:
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
    faults = report_faults(known.faults)
    if json:
        print_json({**effect_document(effect), "faults": faults})
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
