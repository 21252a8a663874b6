"""The model against measurement: which campaign, and the four steps on one page."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.layout import sheet
from rigctl.page.model.challenge_panel import challenge_maker
from rigctl.page.model.source import Source
from rigctl.page.model.view import ModelView
from rigctl.page.parts.plotting import expect_plots
from rigctl.page.parts.presence import kept_page
from rigctl.page.parts.widgets import button
from rigctl.store import ShotState

LEAST_SHOTS = 3


def model_pages(desk: Desk) -> None:
    """Register `/model`, where a campaign is chosen, and `/model/{campaign}`."""

    @kept_page("/model")
    def choose(folder: str = "") -> None:
        with sheet(desk, "Model", "/model"):
            if folder:
                _view(lambda: Source.of_folder(desk.daemon, folder), desk)
            else:
                _choice(desk)

    @kept_page("/model/{campaign}")
    def model(campaign: str) -> None:
        with sheet(desk, f"Model of {campaign}", "/model"):

            def known() -> Source:
                desk.daemon.store.campaigns.one(campaign)
                return Source(desk.daemon, campaign)

            _view(known, desk)


def _view(source: Callable[[], Source], desk: Desk) -> None:
    try:
        found = source()
    except RigError as error:
        with ui.element("div").classes("panel"):
            ui.label("There is nothing to compare here").classes("title")
            ui.label(error.sentence()).classes("empty")
            ui.link("Choose a campaign", "/model")
        return
    expect_plots()
    ModelView(desk, found)


def _choice(desk: Desk) -> None:
    with ui.element("div").classes("columns half"):
        with ui.element("div").classes("panel"):
            ui.label("Campaigns of this rig").classes("title")
            _campaigns(desk)
        with ui.element("div").classes("stack"):
            with ui.element("div").classes("panel"):
                ui.label("A campaign's folder").classes("title")
                ui.label(
                    "As rigctl challenge new, rigctl analyse --out or another laboratory wrote "
                    "it; it is used as it is."
                ).classes("note")
                path = ui.input("Path of the folder").props("outlined dense data-testid=folder")
                path.classes("wide")
                path.on("keydown.enter", lambda: _open(desk, path.value))
                button("Open", lambda: _open(desk, path.value), look="fill", testid="open-folder")
            challenge_maker(desk)


def _campaigns(desk: Desk) -> None:
    found = desk.daemon.store.campaigns.all()
    if not found:
        ui.label(
            "No shot was fired under a campaign's name yet. Fire some on the page Rig with the "
            "field Campaign filled in, or run a sweep: the model needs shots at several pressures "
            "and offsets."
        ).classes("empty")
    for campaign in found:
        measured = campaign.states.get(ShotState.ANALYSED, 0)
        with ui.element("div").classes("beside"):
            ui.link(campaign.name, f"/model/{campaign.name}")
            ui.label(f"{campaign.shots} shots, {measured} measured").classes("aside")


def _open(desk: Desk, path: str | None) -> None:
    try:
        found = Source.of_folder(desk.daemon, (path or "").strip())
    except RigError as error:
        ui.notify(error.sentence(), type="negative", multi_line=True)
        return
    ui.navigate.to(found.address)
