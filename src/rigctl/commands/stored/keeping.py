"""`rigctl verify` and `rigctl backup`: is everything there, and once more elsewhere."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from rigctl.commands.bar import bar
from rigctl.errors import StoreError
from rigctl.exchange.fresh import fresh_folder
from rigctl.opening import read_store
from rigctl.store.integrity.anchors import add_anchor, read_anchors
from rigctl.store.integrity.backup import back_up
from rigctl.store.integrity.verifying import verify_store


def verify(
    campaign: str | None, configuration: Path | None, *, anchor: Path | None = None, as_json: bool
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
    with read_store(configuration) as store, bar() as say:
        head = store.database.head()
        found = verify_store(store, say, campaign, kept)
    if anchor is not None and head is not None and not found.faults:
        add_anchor(anchor, head)
    if as_json:
        _print(json.dumps(asdict(found)))
    else:
        for fault in found.faults:
            _print(f"{fault.part}: {fault.what}")
        _print(
            f"{found.shots} shots, {found.files} files, {found.rows} rows, "
            f"{found.entries} entries of the audit"
        )
        if found.unchecked:
            _print(f"{found.unchecked} results without a digest: read, but not compared")
    if found.faults:
        raise StoreError(
            "the store is not what was stored",
            value=f"{len(found.faults)} faults",
            todo="restore the files named from a backup",
        )


def backup(target: Path, configuration: Path | None, *, as_json: bool) -> None:
    """Copy the store into a folder that is not there, verify the copy, and say what it holds.

    Raises
    ------
    NotFoundError, SettingsError, StoreError
        There is no store, the folder is there already, or the copy is not whole; nothing is left.
    """
    with (
        read_store(configuration) as store,
        fresh_folder(target) as partial,
        bar() as say,
    ):
        done = back_up(store, partial, say)
    if as_json:
        _print(json.dumps({**asdict(done), "folder": str(target)}))
    else:
        _print(f"{target}: {done.shots} shots, {done.files} files, verified")


def _print(text: str) -> None:
    Console(highlight=False, soft_wrap=True, markup=False).print(text)
