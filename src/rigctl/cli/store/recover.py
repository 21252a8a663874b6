"""`rigctl recover`: a lost catalogue, built again from the shots' folders."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import typer

from rigctl.cli.options import Config, Json
from rigctl.cli.output import print_json
from rigctl.config import load
from rigctl.rebuilding import Rebuilt, rebuild

LOST = (
    "not on disk, and lost with the catalogue: exclusions, notes and tags given after the shots, "
    "what was said of campaigns, and the audit of the rig's states; see the latest backup"
)


def recover(*, config: Config = None, json: Json = False) -> None:
    """Build the catalogue of a store again, and say what it holds and what it lacks.

    Raises
    ------
    NotFoundError
        There is no shot to build it from.
    RefusedError
        The catalogue is whole.
    StoreError
        A daemon runs on the store, or the disk refuses; nothing has changed.
    """
    section = load(config).store
    rebuilt = rebuild(Path(section.folder).absolute(), section.database)
    if json:
        print_json(asdict(rebuilt))
        return
    for line in _lines(rebuilt):
        typer.echo(line)


def _lines(rebuilt: Rebuilt) -> list[str]:
    lines = [
        f"rebuilt: {rebuilt.shots} shots, {rebuilt.imports} imported campaigns, "
        f"{rebuilt.sweeps} sweeps"
    ]
    if rebuilt.kept:
        lines.append(f"the former catalogue is kept as {rebuilt.kept}")
    lines += [
        f"shot {shot} had not ended: whether it fired is not known; look at the tubes"
        for shot in rebuilt.open
    ]
    if rebuilt.without_key:
        lines.append(
            f"{len(rebuilt.without_key)} shots are older than the keys in manifests: a request "
            f"repeated under one of their idempotency keys would fire again "
            f"({rebuilt.without_key[0]} to {rebuilt.without_key[-1]})"
        )
    if rebuilt.missing:
        lines.append(
            f"{rebuilt.missing} numbers of shots are not on disk: of them nothing is known"
        )
    lines += [f"not in the catalogue: {what}" for what in rebuilt.unreadable]
    return [*lines, LOST]
