"""Campaigns: which there are, and the page of one."""

from __future__ import annotations

from nicegui import events, ui

from rigctl.errors import RigError
from rigctl.page.campaigns.view import CampaignView
from rigctl.page.desk import Desk
from rigctl.page.layout import sheet
from rigctl.page.parts.presence import kept_page
from rigctl.page.parts.widgets import button
from rigctl.page.shots.table import WHY, column, explain_headings, link_cells
from rigctl.store import CampaignRecord, ShotState

COLUMNS = [
    column("name", "campaign", "left"),
    column("shots", "shots"),
    column("measured", "measured"),
    column("refused", "refused"),
    column("other", "not analysed"),
    column("first", "first shot", "left"),
    column("last", "last shot", "left"),
    column("tags", "tags", "left"),
    column("note", "note", "left", **WHY),
]
HEADINGS = {
    "name": "Shots of one campaign are fitted together.",
    "shots": "All that were accepted under this name, whatever became of them.",
    "measured": "Shots that have coefficients.",
    "refused": "Shots whose frames could not be measured; each with the reason.",
    "other": "Shots under way, and those that came to nothing.",
    "first": "When the first shot was accepted.",
    "last": "When the latest shot was accepted.",
    "tags": "Words that a person gave it, to filter by.",
    "note": "What a person said of it.",
}


def campaign_pages(desk: Desk) -> None:
    """Register `/campaigns` and `/campaigns/{campaign}`."""

    @kept_page("/campaigns")
    def campaigns() -> None:
        with sheet(desk, "Campaigns", "/campaigns"), ui.element("div").classes("panel"):
            with ui.element("div").classes("title"):
                ui.label("Campaigns")
                ui.space()
                bring = button("Bring your own data", lambda: ui.navigate.to("/own"), testid="own")
                bring.tooltip("a film of a ball, or the tables of another laboratory")
            _listed(desk.daemon.store.campaigns.all())

    @kept_page("/campaigns/{campaign}")
    def one(campaign: str) -> None:
        with sheet(desk, f"Campaign {campaign}", "/campaigns"):
            try:
                desk.daemon.store.campaigns.one(campaign)
            except RigError as error:
                ui.label(error.sentence()).classes("verdict bad")
                ui.link("All campaigns", "/campaigns")
                return
            CampaignView(desk, campaign)


def _listed(found: list[CampaignRecord]) -> None:
    if not found:
        ui.label(
            "There is none yet: fire a shot on the page Rig with the field Campaign filled in, or "
            "run a sweep."
        ).classes("empty")
        return
    with ui.element("div").classes("beside"):
        given = ui.input(placeholder="Filter: a part of the name, a date …")
        given.props('outlined dense clearable data-testid=filter aria-label="Filter"')
        given.classes("filter")
    rows = [_row(campaign) for campaign in found]
    table = ui.table(rows=rows, columns=COLUMNS, pagination=20, row_key="name")
    table.props("dense flat data-testid=campaigns").classes("wide").bind_filter_from(given, "value")

    explain_headings(table, HEADINGS)
    link_cells(table, "name", "/campaigns/", "name")

    def open_one(event: events.GenericEventArguments) -> None:
        ui.navigate.to(f"/campaigns/{event.args[1]['name']}")

    table.on("rowClick", open_one)


def _row(campaign: CampaignRecord) -> dict[str, object]:
    measured = campaign.states.get(ShotState.ANALYSED, 0)
    refused = campaign.states.get(ShotState.REFUSED, 0)
    return {
        "name": campaign.name,
        "shots": campaign.shots,
        "measured": measured,
        "refused": refused,
        "other": campaign.shots - measured - refused,
        "first": f"{campaign.first_at.astimezone():%Y-%m-%d %H:%M}",
        "last": f"{campaign.last_at.astimezone():%Y-%m-%d %H:%M}",
        "tags": ", ".join(campaign.tags),
        "note": campaign.note or "",
    }
