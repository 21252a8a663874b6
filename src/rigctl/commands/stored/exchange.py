"""`rigctl import` and `rigctl export`: campaigns as exchange folders."""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from rigctl.commands.bar import bar
from rigctl.commands.stored.shots import actor
from rigctl.config import load
from rigctl.exchange import export_campaign
from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import import_campaign
from rigctl.opening import own_store, read_store


def import_folder(
    folder: Path, name: str | None, configuration: Path | None, *, as_json: bool
) -> None:
    """Import an exchange folder into the store of a configuration and say what came of it.

    Raises
    ------
    AnalysisInputError, SettingsError, RefusedError, StoreError
        As `import_campaign`; nothing is imported.
    """
    kept = load(configuration)
    with bar() as say:
        # Read before a store is opened, which may be the first one here.
        contents = read_contents(folder, say)
        with closing(own_store(kept, shared=True)) as store:
            found = import_campaign(store, contents, actor(), name=name, say=say)
    if as_json:
        _print(json.dumps(asdict(found)))
        return
    _print(f"campaign {found.campaign}: {found.shots} shots, {found.measured} of them measured")
    if found.to_analyse:
        _print(f"{found.to_analyse} wait for their analysis: rigctl reanalyse {found.campaign}")


def export_folder(
    campaign: str, folder: Path, configuration: Path | None, *, as_json: bool
) -> None:
    """Export a campaign from the store of a configuration and say what was written.

    Raises
    ------
    NotFoundError, AnalysisInputError, SettingsError, StoreError
        As `export_campaign`; nothing is written.
    """
    with read_store(configuration) as store, bar() as say:
        found = export_campaign(store, campaign, folder, say=say)
    if as_json:
        _print(json.dumps({**asdict(found), "folder": str(found.folder)}))
        return
    _print(f"{found.folder}: {found.shots} shots of campaign {found.campaign}")
    if found.left_out:
        _print(f"{found.left_out} shots without frames are not in it")


def _print(text: str) -> None:
    Console(highlight=False, soft_wrap=True, markup=False).print(text)
