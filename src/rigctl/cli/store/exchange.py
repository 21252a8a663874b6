"""`rigctl import` and `rigctl export`: campaigns as exchange folders."""

from __future__ import annotations

from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from rigctl.cli.options import Config, Json, StoredCampaign
from rigctl.cli.output import bar, print_json, print_line
from rigctl.cli.store.shots import actor
from rigctl.config import load
from rigctl.exchange import export_campaign
from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import import_campaign
from rigctl.opening import own_store, read_store


def import_folder(
    folder: Annotated[Path, typer.Argument(help="Exchange folder.")],
    *,
    name: Annotated[str | None, typer.Option(help="Name it gets in the catalogue.")] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Import an exchange folder into the store of a configuration and say what came of it.

    Raises
    ------
    AnalysisInputError, SettingsError, RefusedError, StoreError
        As `import_campaign`; nothing is imported.
    """
    kept = load(config)
    with bar() as report:
        # Read before a store is opened, which may be the first one here.
        contents = read_contents(folder, report)
        with closing(own_store(kept, shared=True)) as store:
            found = import_campaign(store, contents, actor(), name=name, progress=report)
    if json:
        print_json(asdict(found))
        return
    print_line(f"campaign {found.campaign}: {found.shots} shots, {found.measured} of them measured")
    if found.to_analyse:
        print_line(f"{found.to_analyse} wait for their analysis: rigctl reanalyse {found.campaign}")


def export_folder(
    campaign: StoredCampaign,
    folder: Annotated[Path, typer.Argument(help="Exchange folder that is not there yet.")],
    *,
    config: Config = None,
    json: Json = False,
) -> None:
    """Export a campaign from the store of a configuration and say what was written.

    Raises
    ------
    NotFoundError, AnalysisInputError, SettingsError, StoreError
        As `export_campaign`; nothing is written.
    """
    with read_store(config) as store, bar() as report:
        found = export_campaign(store, campaign, folder, progress=report)
    if json:
        print_json({**asdict(found), "folder": str(found.folder)})
        return
    print_line(f"{found.folder}: {found.shots} shots of campaign {found.campaign}")
    if found.left_out:
        print_line(f"{found.left_out} shots without frames are not in it")
