"""Bring your own: drop a film or a campaign, look, say how large the ball is, measure, compare."""

from __future__ import annotations

from collections.abc import Sequence

from nicegui import ui

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.layout import sheet
from rigctl.page.model.source import Source
from rigctl.page.own.brought import Brought, brought_before, known, looks_tracked
from rigctl.page.own.dropping import SHOWN_AT, drop_field
from rigctl.page.own.film import FilmView
from rigctl.page.own.table import TableView
from rigctl.page.own.track import AS_IMPACTS, TrackView
from rigctl.page.parts.presence import kept_page
from rigctl.page.parts.widgets import button

KINDS = (
    "Films of a ball that bounces: MP4, MOV, AVI, MKV, NPY, Photron or Phantom; several at once.",
    "The pictures of one film, all PNG, TIFF or DNG together.",
    "A tracker's table as CSV: places of a ball that bounces (Tracker, ImageJ, TrackMate, trackpy, "
    "DLTdv), or the times between bounces of phyphox.",
    "A table of impacts as CSV: speeds before and after, or heights of fall and rebound.",
    "A campaign of any laboratory: its exchange folder as one ZIP.",
)


def own_pages(desk: Desk) -> None:
    """Register `/own`; `?brought=` names what was dropped before, `&table=` what a table is."""

    @kept_page(SHOWN_AT)
    def own(brought: str = "", table: str = "") -> None:
        with sheet(desk, "Your own data", "/campaigns"):
            ui.html("Bring your own collision", sanitize=False, tag="h2").classes("own-heading")
            ui.label(
                "A film of any ball, or the tables of any laboratory. It stays on this rig's "
                "computer: nothing goes anywhere else."
            ).classes("note")
            if not brought:
                _drop()
                _before(brought_before(desk.daemon.store.path))
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
                tracked = looks_tracked(found.table) and table != AS_IMPACTS
                view = TrackView if tracked else TableView
                view(desk, found, found.table)
            else:
                _campaign(desk, found)


def _drop() -> None:
    with ui.element("section").classes("panel drop"):
        ui.html("Drop it here", sanitize=False, tag="h3").classes("card-heading")
        with ui.element("ul").classes("chain"):
            for kind in KINDS:
                ui.html(kind, sanitize=False, tag="li")
        drop_field()


def _before(found: Sequence[Brought]) -> None:
    """List what was brought before, each with its address."""
    if not found:
        return
    with ui.element("section").classes("panel").props("data-testid=brought-before"):
        ui.html("Brought before", sanitize=False, tag="h3").classes("card-heading")
        with ui.element("ul").classes("chain"):
            for one in found:
                with ui.element("li"):
                    ui.link(one.name, f"{SHOWN_AT}?brought={one.token}")
                    if measured := len(one.results()):
                        ui.label(f"{measured} measured").classes("note")


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
