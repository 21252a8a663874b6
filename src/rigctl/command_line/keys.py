"""`rigctl keys`: who may do what."""

from __future__ import annotations

from typing import Annotated

import typer

from rigctl.access.scopes import Scope
from rigctl.command_line.options import Config, Json

keys = typer.Typer(help="Named keys with scopes: add, list and revoke them.")
Name = Annotated[str, typer.Argument(help="Of the person or program; the audit knows it.")]


@keys.command("add")
def add(
    name: Name,
    *,
    scope: Annotated[list[Scope], typer.Option(help="What it may do; stands once for each.")],
    expires: Annotated[
        str | None, typer.Option(help="When it ends: days as in 30d, or a time (ISO 8601, UTC).")
    ] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Add a key and print it, this once."""
    from rigctl.commands.rig.keys import add as run

    run(name, scope, expires, config, as_json=json)


@keys.command("list")
def list_keys(*, config: Config = None, json: Json = False) -> None:
    """List every named key, also those that open nothing any more."""
    from rigctl.commands.rig.keys import show

    show(config, as_json=json)


@keys.command("revoke")
def revoke(name: Name, *, config: Config = None) -> None:
    """Let a key open nothing any more, at once."""
    from rigctl.commands.rig.keys import revoke as run

    run(name, config)
