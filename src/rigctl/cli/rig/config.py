"""`rigctl config check`: configuration files, with every fault, before a device is opened."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rigctl.cli.options import Json
from rigctl.cli.output import print_json
from rigctl.config import Configuration, faults_of, parse, read_toml
from rigctl.config.bench import Bench
from rigctl.documents import Json as Document
from rigctl.errors import ConfigurationError

BENCHES = ("stage", "disk")
FAULTY = 2


def check(
    files: Annotated[list[Path], typer.Argument(help="Configurations of rigs (TOML).")],
    *,
    json: Json = False,
) -> None:
    """Say of each file which rig it is, or what in it is wrong; end with 2 where anything is."""
    told: list[Document] = []
    for path in files:
        faults, rig = _checked(path)
        told.append(
            {
                "file": str(path),
                "rig": rig,
                "faults": [
                    {"part": one.part, "what": one.what, "value": one.value, "limit": one.limit}
                    | {"todo": one.todo}
                    for one in faults
                ],
            }
        )
        for fault in faults:
            typer.echo(f"rigctl: {fault.sentence()}", err=True)
        if rig is not None and not json:
            typer.echo(f"{path}: no fault; {rig}")
    if json:
        print_json({"files": told})
    if any(one["faults"] for one in told):
        raise typer.Exit(FAULTY)


def _checked(path: Path) -> tuple[list[ConfigurationError], str | None]:
    """Return the faults of a file, or else what it describes."""
    try:
        document = read_toml(path)
        bench = document.get("apparatus") in BENCHES
        faults = faults_of(Bench if bench else Configuration, document, str(path))
        if faults:
            return faults, None
        if bench:
            return [], f"a {document['apparatus']} for rigctl qualify {document['apparatus']}"
        # The service is slow to load.
        from rigctl.cli.rig.serve import require_safe  # noqa: PLC0415

        found = parse(document, str(path))
        require_safe(found.service)
    except ConfigurationError as error:
        if error.part is None or not error.part.startswith(str(path)):
            part = str(path) if error.part is None else f"{path}: {error.part}"
            error = ConfigurationError(
                error.what, part=part, value=error.value, limit=error.limit, todo=error.todo
            )
        return [error], None
    return [], _described(found)


def _described(rig: Configuration) -> str:
    kind = "REAL RIG" if rig.simulation is None else "simulated rig"
    return (
        f"{kind} {rig.name!r}: {rig.apparatus} apparatus, fires by {rig.trigger.driver}, "
        f"records by {rig.camera.kind}, keeps shots in {rig.store.folder}"
    )
