"""Bring your own: drop a film or a campaign, look, say how large the ball is, measure, compare."""

from __future__ import annotations

from nicegui import ui

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.layout import sheet
from rigctl.page.model.source import Source
from rigctl.page.own.brought import Brought, known
from rigctl.page.own.dropping import SHOWN_AT, drop_field
from rigctl.page.own.film import FilmView
from rigctl.page.own.table import TableView
from rigctl.page.parts.presence import kept_page
from rigctl.page.parts.widgets import button

KINDS = (
    "Films of a ball that bounces: MP4, MOV, AVI, MKV, NPY, Photron or Phantom; several at once.",
    "The pictures of one film, all PNG or TIFF together.",
    "A table of impacts as CSV: speeds before and after, or heights of fall and rebound.",
    "A campaign of any laboratory: its exchange folder as one ZIP.",
)


def own_pages(desk: Desk) -> None:
    """Register `/own`; `?brought=` names what was dropped before."""

    @kept_page(SHOWN_AT)
    def own(brought: str = "") -> None:
        with sheet(desk, "Your own data", "/campaigns"):
            ui.html("Bring your own collision", sanitize=False, tag="h2").classes("own-heading")
            ui.label(
                "A film of any ball, or the tables of any laboratory. It stays on this rig's "
                "computer: nothing goes anywhere else."
            ).classes("note")
            if not brought:
                _drop()
                return
            try:
                found = known(desk.daemon.store.path, brought)
            except RigError as error:
                ui.label(error.sentence()).classes("verdict bad")
                _drop()
                return
            if found.films:
                FilmView(desk, found)
            elif found.table is not None:
                TableView(desk, found, found.table)
            else:
                _campaign(desk, found)


def _drop() -> None:
    with ui.element("section").classes("panel drop"):
        ui.html("Drop it here", sanitize=False, tag="h3").classes("card-heading")
        with ui.element("ul").classes("chain"):
            for kind in KINDS:
                ui.html(kind, sanitize=False, tag="li")
        drop_field()


def _campaign(desk: Desk, found: Brought) -> None:
    with ui.element("section").classes("panel").props("data-testid=own-campaign"):
        source = Source.of_folder(desk.daemon, str(found.campaign))
        ui.label(f"Campaign {source.title}").classes("title")
        ui.label("Its tables are used as they are; a fault in them is named with its line.")
        button(
            "Compare with the model",
            lambda: ui.navigate.to(source.address),
            look="fill",
            testid="own-compare",
        )
        ui.link("bring something else", SHOWN_AT).classes("note")
