"""The commands; each loads what it needs when it runs, so that --help answers at once."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer
from typer.exceptions import TyperException

from rigctl.command_line.analysis import analysis
from rigctl.command_line.calibrate import calibration
from rigctl.command_line.campaign_words import campaign_words
from rigctl.command_line.campaigns import campaigns
from rigctl.command_line.challenge import challenge
from rigctl.command_line.discs import finding
from rigctl.command_line.effect import effect
from rigctl.command_line.exports import exporting
from rigctl.command_line.keys import keys
from rigctl.command_line.model import model
from rigctl.command_line.qualify import qualify
from rigctl.command_line.report import reporting
from rigctl.command_line.rig import rig
from rigctl.command_line.shots import shots
from rigctl.command_line.sweep import sweep
from rigctl.errors import (
    AnalysisInputError,
    ConfigurationError,
    DeviceError,
    NotFoundError,
    RecordingNotConfirmedError,
    RefusedError,
    RigError,
    SettingsError,
    StoreError,
)

BAD_INPUT, REFUSED, NOT_FOUND = 2, 3, 4

_EXIT_CODES: tuple[tuple[type[RigError], int], ...] = (
    (NotFoundError, NOT_FOUND),
    (RefusedError, REFUSED),
    (DeviceError, REFUSED),
    (RecordingNotConfirmedError, REFUSED),
    (StoreError, REFUSED),
    (AnalysisInputError, BAD_INPUT),
    (ConfigurationError, BAD_INPUT),
    (SettingsError, BAD_INPUT),
)

app = typer.Typer(
    name="rigctl",
    help="A collision laboratory: fire the rig, film two spheres, measure the impact.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
app.add_typer(rig)
app.add_typer(sweep, name="sweep", no_args_is_help=True)
app.add_typer(shots, name="shots", no_args_is_help=True)
app.add_typer(campaigns)
app.add_typer(campaign_words, name="campaigns", no_args_is_help=True)
app.add_typer(keys, name="keys", no_args_is_help=True)
app.add_typer(analysis)
app.add_typer(calibration)
app.add_typer(finding)
app.add_typer(reporting)
app.add_typer(exporting)
app.add_typer(model, name="model", no_args_is_help=True)
app.add_typer(effect, name="effect", no_args_is_help=True)
app.add_typer(challenge, name="challenge", no_args_is_help=True)
app.add_typer(qualify, name="qualify", no_args_is_help=True)


def _show_version(wanted: bool) -> None:
    if wanted:
        # What the package's metadata say takes a while to find.
        from rigctl import __version__  # noqa: PLC0415

        typer.echo(f"rigctl {__version__}")
        raise typer.Exit


@app.callback()
def rigctl(
    *,
    version: Annotated[
        bool,
        typer.Option("--version", is_eager=True, callback=_show_version, help="Say which this is."),
    ] = False,
) -> None:
    """Keep the commands a group, however many there are."""


def run(arguments: list[str]) -> int:
    """Run one command and return its exit code; what failed stands on standard error.

    0 is success, 2 bad input, 3 a rig that refuses or cannot, 4 "not found", 130 an interruption
    by Ctrl-C, 1 anything else.
    """
    # Read where linear algebra is loaded, by the commands: more threads wait for each other there.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        code = app(arguments or ["--help"], prog_name="rigctl", standalone_mode=False)
    except RigError as error:
        typer.echo(f"rigctl: {error.sentence()}", err=True)
        return next((code for kind, code in _EXIT_CODES if isinstance(error, kind)), 1)
    except TyperException as error:
        typer.echo(f"rigctl: {error.format_message()}", err=True)
        return BAD_INPUT
    return code if isinstance(code, int) else 0


def main() -> None:
    """Entry point of the `rigctl` script."""
    sys.exit(run(sys.argv[1:]))
