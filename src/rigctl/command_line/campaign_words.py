"""`rigctl campaigns`: which there are, and what is said of each."""

from __future__ import annotations

from typing import Annotated

import typer

from rigctl.command_line.options import Config, Json

campaign_words = typer.Typer(help="List stored campaigns; note and tag them.")

Campaign = Annotated[str, typer.Argument(help="Its name in the catalogue.")]


@campaign_words.command("list")
def list_campaigns(
    *,
    tag: Annotated[str | None, typer.Option(help="Only those with this tag.")] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """List stored campaigns, the one with the latest shot first."""
    from rigctl.commands.stored.campaigns import show
    from rigctl.commands.stored.shots import kept

    with kept(config) as store:
        show(store, tag, as_json=json)


@campaign_words.command("note")
def note(
    campaign: Campaign,
    text: Annotated[str | None, typer.Argument(help="Without it the note is taken away.")] = None,
    *,
    config: Config = None,
    json: Json = False,
) -> None:
    """Put a note in the place of a campaign's note."""
    from rigctl.commands.stored.campaigns import annotate
    from rigctl.commands.stored.shots import kept

    with kept(config) as store:
        annotate(store, campaign, text, as_json=json)


@campaign_words.command("tag")
def tag(
    campaign: Campaign,
    tags: Annotated[list[str] | None, typer.Argument(help="Without any, all are taken away.")] = (
        None
    ),
    *,
    config: Config = None,
    json: Json = False,
) -> None:
    """Give a campaign exactly these tags."""
    from rigctl.commands.stored import campaigns as commands
    from rigctl.commands.stored.shots import kept

    with kept(config) as store:
        commands.tag(store, campaign, tags or [], as_json=json)
