"""Commands that keep campaigns: in, out, proved, copied, analysed once more."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rigctl.command_line.analysis import Method
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
    from rigctl.commands.stored.exchange import import_folder

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
    from rigctl.commands.stored.exchange import export_folder

    export_folder(campaign, folder, config, as_json=json)


@campaigns.command()
def reanalyse(
    campaign: Campaign,
    *,
    method: Annotated[Method, typer.Option(help="How images are measured.")] = Method.PHOTOMETRIC,
    scheduler: Annotated[
        str | None,
        typer.Option(help="Address of a Dask scheduler; without it processes of this host."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, max=256, help="Processes; default: one a processor.")
    ] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Analyse a stored campaign once more; results are added beside those there are."""
    from rigctl.commands.stored.reanalyse import reanalyse as run

    run(campaign, method.value, config, scheduler=scheduler, workers=workers, as_json=json)


@campaigns.command()
def verify(
    campaign: Annotated[
        str | None, typer.Argument(help="Only its shots; without it everything.")
    ] = None,
    *,
    anchor: Annotated[
        Path | None,
        typer.Option(help="File elsewhere with heads of the audit; the present one is added."),
    ] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Compare all that is stored with its digests, its manifests and its audit."""
    from rigctl.commands.stored.keeping import verify as run

    run(campaign, config, anchor=anchor, as_json=json)


@campaigns.command()
def recover(*, config: Config = None, json: Json = False) -> None:
    """Build a lost or damaged catalogue again from the shots' folders; fires nothing."""
    from rigctl.commands.stored.recover import recover as run

    run(config, as_json=json)


@campaigns.command()
def backup(
    folder: Annotated[Path, typer.Argument(help="Folder that is not there yet.")],
    *,
    config: Config = None,
    json: Json = False,
) -> None:
    """Copy the store, while a daemon fires or none does, and verify the copy."""
    from rigctl.commands.stored.keeping import backup as run

    run(folder, config, as_json=json)
