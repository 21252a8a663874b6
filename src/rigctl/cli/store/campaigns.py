"""`rigctl campaigns`: list stored campaigns, note and tag them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from rigctl.cli.options import Config, Json, StoredCampaign
from rigctl.cli.output import print_json
from rigctl.cli.store.shots import actor, kept, valid_tags
from rigctl.service.campaign_models import CampaignView
from rigctl.store import CampaignRecord

NONE_YET = "rigctl: this store holds no campaign yet"


def list_campaigns(
    *,
    tag: Annotated[str | None, typer.Option(help="Only those with this tag.")] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Print all campaigns, or those with a tag, the one with the latest shot first."""
    with kept(config) as store:
        found = store.campaigns.all(tag)
        _print(found, as_json=json)
        if not found:
            typer.echo("rigctl: no stored campaign has this tag" if tag else NONE_YET, err=True)


def note(
    campaign: StoredCampaign,
    text: Annotated[str | None, typer.Argument(help="Without it the note is taken away.")] = None,
    *,
    config: Config = None,
    json: Json = False,
) -> None:
    """Put a note in the place of a campaign's note; raise `NotFoundError` for no campaign."""
    with kept(config) as store:
        _print([store.annotate_campaign(campaign, text, actor())], as_json=json)


def tag(
    campaign: StoredCampaign,
    tags: Annotated[list[str] | None, typer.Argument(help="Without any, all are taken away.")] = (
        None
    ),
    *,
    config: Config = None,
    json: Json = False,
) -> None:
    """Give a campaign exactly these tags.

    Raises
    ------
    NotFoundError
        There is no such campaign.
    SettingsError
        A word is no tag.
    """
    with kept(config) as store:
        _print([store.tag_campaign(campaign, valid_tags(tags or []), actor())], as_json=json)


def _print(campaigns: Sequence[CampaignRecord], *, as_json: bool) -> None:
    if as_json:
        listed = [CampaignView.of(campaign).model_dump(mode="json") for campaign in campaigns]
        print_json({"campaigns": listed})
        return
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("campaign", "shots", "last", "tags", "note"):
        table.add_column(heading, overflow="fold")
    for campaign in campaigns:
        last = f"{campaign.last_at:%Y-%m-%d %H:%M}"
        words = (",".join(campaign.tags), campaign.note or "")
        table.add_row(campaign.name, str(campaign.shots), last, *words)
    Console(highlight=False, soft_wrap=True, markup=False).print(table)
