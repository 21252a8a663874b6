"""`rigctl verify` and `rigctl backup`: is everything there, and once more elsewhere."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from rigctl.cli.options import Config, Json
from rigctl.cli.output import bar, print_json, print_line
from rigctl.errors import StoreError
from rigctl.exchange.fresh import fresh_folder
from rigctl.opening import read_store
from rigctl.store.integrity.anchors import add_anchor, read_anchors
from rigctl.store.integrity.copying import back_up
from rigctl.store.integrity.verifying import verify_store


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
    """Compare all that is stored with its digests and print what is wrong.

    With an `anchor` the audit is compared with the heads in that file as well; where nothing is
    wrong, its present head is added to them.

    Raises
    ------
    NotFoundError
        There is no store, or no such campaign.
    SettingsError
        The file of anchors is none.
    StoreError
        Something is not as it was stored; all of it is printed first.
    """
    kept = [] if anchor is None else [(str(anchor), each) for each in read_anchors(anchor)]
    with read_store(config) as store, bar() as report:
        head = store.database.head()
        found = verify_store(store, report, campaign, kept)
    if anchor is not None and head is not None and not found.faults:
        add_anchor(anchor, head)
    if json:
        print_json(asdict(found))
    else:
        for fault in found.faults:
            print_line(f"{fault.part}: {fault.what}")
        print_line(
            f"{found.shots} shots, {found.files} files, {found.rows} rows, "
            f"{found.entries} entries of the audit"
        )
        if found.unchecked:
            print_line(f"{found.unchecked} results without a digest: read, but not compared")
    if found.faults:
        raise StoreError(
            "the store is not what was stored",
            value=f"{len(found.faults)} faults",
            todo="restore the files named from a backup",
        )


def backup(
    folder: Annotated[Path, typer.Argument(help="Folder that is not there yet.")],
    *,
    config: Config = None,
    json: Json = False,
) -> None:
    """Copy the store into a folder that is not there, verify the copy, and say what it holds.

    Raises
    ------
    NotFoundError, SettingsError, StoreError
        There is no store, the folder is there already, or the copy is not whole; nothing is left.
    """
    with (
        read_store(config) as store,
        fresh_folder(folder) as partial,
        bar() as report,
    ):
        done = back_up(store, partial, report)
    if json:
        print_json({**asdict(done), "folder": str(folder)})
    else:
        print_line(f"{folder}: {done.shots} shots, {done.files} files, verified")
