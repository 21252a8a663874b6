"""`rigctl effect`: the effects that a campaign may lack."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from rigctl.command_line.options import Json, OwnEffects

effect = typer.Typer(help="The effects that a campaign may lack, and effects of your own.")


class EffectStage(StrEnum):
    """Where on the way from contact to image an effect acts."""

    CONTACT = "contact"
    FLIGHT = "flight"
    CAMERA = "camera"
    CLOCK = "clock"


@effect.command("new")
def effect_new(
    name: Annotated[str, typer.Argument(help="Its name: lower case, words joined by hyphens.")],
    *,
    stage: Annotated[EffectStage, typer.Option(help="Where it acts.")] = EffectStage.CONTACT,
    folder: Annotated[Path, typer.Option(help="Folder the file is written to.")] = Path("effects"),
) -> None:
    """Write a file to fill in for an effect of your own."""
    from rigctl.commands.effect import new

    path = new(name, stage=stage.value, folder=folder)
    typer.echo(f"{path}: fill it in, then rigctl model rank CAMPAIGN --effects {folder}")


@effect.command("list")
def effect_list(*, folder: OwnEffects = None, json: Json = False) -> None:
    """List all effects with their stages and parameters."""
    from rigctl.commands.effect import listing

    listing(folder, as_json=json)


@effect.command("show")
def effect_show(
    name: Annotated[str, typer.Argument(help="Name of the effect.")],
    *,
    folder: OwnEffects = None,
    json: Json = False,
) -> None:
    """Say what an effect is, what gives it away, and what it is confused with."""
    from rigctl.commands.effect import show

    show(name, folder, as_json=json)
