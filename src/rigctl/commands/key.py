"""The key that a command was given, by whatever way."""

from __future__ import annotations

import typer

from rigctl.access.strength import Chosen


def say_warning(chosen: Chosen) -> None:
    """Say in one line on standard error what is wrong with the way a key was given."""
    if chosen.warning is not None:
        typer.echo(f"rigctl: warning: {chosen.warning}", err=True)
