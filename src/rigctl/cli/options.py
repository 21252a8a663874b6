"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from rigctl.access.strength import Chosen, chosen_key

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
Campaign = Annotated[
    Path, typer.Argument(help="Campaign folder, or a campaign's name in the store.")
]
StoredCampaign = Annotated[str, typer.Argument(help="Its name in the catalogue.")]
With = Annotated[
    list[str] | None,
    typer.Option("--with", help="Add this effect of the catalogue; may be given several times."),
]
Streamed = Annotated[
    bool,
    typer.Option("--stream", help="Go over poses.csv in parts: memory for any number of shots."),
]
Pictures = Annotated[
    Path | None, typer.Option("--out", help="Write pictures (PNG and SVG) into this folder.")
]
Workers = Annotated[
    int | None, typer.Option(min=1, max=256, help="Processes; default: one a processor.")
]
Method = Literal["thesis", "photometric"]
MeasuredBy = Annotated[Method, typer.Option("--method", help="How images are measured.")]


def given_key(option: str | None, file: Path | None) -> Chosen | None:
    """Return the key of the option, of the file or of the environment; None without any.

    What is wrong with the way it was given stands in one line on standard error.

    Raises
    ------
    ConfigurationError
        The file cannot be read.
    """
    chosen = chosen_key(option, file)
    if chosen is not None and chosen.warning is not None:
        typer.echo(f"rigctl: warning: {chosen.warning}", err=True)
    return chosen
