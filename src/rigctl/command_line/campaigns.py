"""Commands that keep campaigns: in, out, proved, copied, analysed once more."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rigctl.command_line.options import Config, Json

campaigns = typer.Typer()

Campaign = Annotated[str, typer.Argument(help="Its name in the catalogue.")]


@campaigns.command("import")
def import_(
    folder: Annotated[Path, typer.Argument(help="Exchange folder.")],
    *,
    name: Annotated[str | None, typer.Option(help="Name it gets in the catalogue.")] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Take an exchange folder into the catalogue, whole or not at all."""
    from rigctl.commands.exchange import import_folder

    import_folder(folder, name, config, as_json=json)


@campaigns.command()
def export(
    campaign: Campaign,
    folder: Annotated[Path, typer.Argument(help="Exchange folder that is not there yet.")],
    *,
    config: Config = None,
    json: Json = False,
) -> None:
    """Write a campaign of the catalogue as an exchange folder."""
    from rigctl.commands.exchange import export_folder

    export_folder(campaign, folder, config, as_json=json)
