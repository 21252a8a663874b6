"""`rigctl shots`: what is kept of each shot, and what is said of it afterwards."""

from __future__ import annotations

from typing import Annotated

import typer

from rigctl.command_line.options import Config, Json

shots = typer.Typer(help="List stored shots; exclude, include, note and tag them.")

Shot = Annotated[str, typer.Argument(help="Its name, or its number.")]
Several = Annotated[list[str], typer.Argument(help="Their names, or their numbers.")]
Of = Annotated[
    str | None,
    typer.Option("--campaign", help="Numbers are those of this campaign, as its fits name them."),
]


@shots.command("list")
def list_shots(
    *,
    campaign: Annotated[str | None, typer.Option(help="Only those of this campaign.")] = None,
    state: Annotated[str | None, typer.Option(help="Only those that stand there.")] = None,
    tag: Annotated[str | None, typer.Option(help="Only those with this tag.")] = None,
    excluded: Annotated[
        bool | None,
        typer.Option("--excluded/--counting", help="Only those that do not count, or that do."),
    ] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """List stored shots, oldest first."""
    from rigctl.commands.stored.shots import Filter, kept, show, state_named

    wanted = Filter(campaign, None if state is None else state_named(state), tag, excluded)
    with kept(config) as store:
        show(store, wanted, as_json=json)


@shots.command("exclude")
def exclude(
    shot: Several,
    *,
    reason: Annotated[str, typer.Option(help="Why; the audit keeps it.")],
    campaign: Of = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Leave shots out of every fit; nothing of them is deleted."""
    from rigctl.commands.stored import shots as commands

    with commands.kept(config) as store:
        commands.exclude(store, shot, reason, campaign, as_json=json)


@shots.command("include")
def include(
    shot: Several, *, campaign: Of = None, config: Config = None, json: Json = False
) -> None:
    """Let shots count again."""
    from rigctl.commands.stored import shots as commands

    with commands.kept(config) as store:
        commands.include(store, shot, campaign, as_json=json)


@shots.command("note")
def note(
    shot: Shot,
    text: Annotated[str | None, typer.Argument(help="Without it the note is taken away.")] = None,
    *,
    campaign: Of = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Put a note in the place of a shot's note."""
    from rigctl.commands.stored import shots as commands

    with commands.kept(config) as store:
        commands.annotate(store, shot, text, campaign, as_json=json)


@shots.command("tag")
def tag(
    shot: Shot,
    tags: Annotated[list[str] | None, typer.Argument(help="Without any, all are taken away.")] = (
        None
    ),
    *,
    campaign: Of = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Give a shot exactly these tags."""
    from rigctl.commands.stored import shots as commands

    with commands.kept(config) as store:
        commands.tag(store, shot, tags or [], campaign, as_json=json)
