"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Config = Annotated[
    Path | None,
    typer.Option("--config", help="Configuration of the rig (TOML); without it all is simulated."),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on standard output.")]
OwnEffects = Annotated[
    Path | None,
    typer.Option("--effects", help="Folder of effects of your own, beside the catalogue."),
]
Key = Annotated[
    str | None,
    typer.Option(
        "--key", help="Key of the daemon; best in RIGCTL_KEY. Without any the store's key file."
    ),
]
KeyFile = Annotated[Path | None, typer.Option("--key-file", help="File whose one line is the key.")]
