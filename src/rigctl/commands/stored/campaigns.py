"""`rigctl campaigns`: list stored campaigns, note and tag them."""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence

from rich.console import Console
from rich.table import Table

from rigctl.commands.stored.shots import actor, valid_tags
from rigctl.service.campaign_models import CampaignView
from rigctl.store import CampaignRecord, Store


def show(store: Store, tag: str | None, *, as_json: bool) -> None:
    """Print all campaigns, or those with a tag, the one with the latest shot first."""
    _print(store.campaigns.all(tag), as_json=as_json)


def annotate(store: Store, campaign: str, note: str | None, *, as_json: bool) -> None:
    """Put a note in the place of a campaign's note; raise `NotFoundError` for no campaign."""
    _print([store.annotate_campaign(campaign, note, actor())], as_json=as_json)


def tag(store: Store, campaign: str, tags: Collection[str], *, as_json: bool) -> None:
    """Give a campaign exactly these tags.

    Raises
    ------
    NotFoundError
        There is no such campaign.
    SettingsError
        A word is no tag.
    """
    _print([store.tag_campaign(campaign, valid_tags(tags), actor())], as_json=as_json)


def _print(campaigns: Sequence[CampaignRecord], *, as_json: bool) -> None:
    console = Console(highlight=False, soft_wrap=True, markup=False)
    if as_json:
        listed = [CampaignView.of(campaign).model_dump(mode="json") for campaign in campaigns]
        console.file.write(json.dumps({"campaigns": listed}, allow_nan=False) + "\n")
        return
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("campaign", "shots", "last", "tags", "note"):
        table.add_column(heading, overflow="fold")
    for campaign in campaigns:
        last = f"{campaign.last_at:%Y-%m-%d %H:%M}"
        words = (",".join(campaign.tags), campaign.note or "")
        table.add_row(campaign.name, str(campaign.shots), last, *words)
    console.print(table)
