"""Shots: the list of all, and one with film, coefficients and what became of it."""

from __future__ import annotations

from typing import Any

from nicegui import events, ui

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S, sheet
from rigctl.page.order_form import words
from rigctl.page.shot_residuals import ShotResiduals
from rigctl.page.shot_view import coefficients, film, result_of
from rigctl.page.tables import Line, facts
from rigctl.page.widgets import button
from rigctl.reanalysing import ENDED
from rigctl.store import ShotRecord

MOST_LISTED = 500
COLUMNS: list[dict[str, Any]] = [
    {"name": name, "label": label, "field": name, "sortable": True, "align": align}
    for name, label, align in (
        ("number", "shot", "right"),
        ("state", "state", "left"),
        ("campaign", "campaign", "left"),
        ("pressure_a", "pressure a, kPa", "right"),
        ("pressure_b", "pressure b, kPa", "right"),
        ("offset", "offset, mm", "right"),
        ("at", "accepted", "left"),
        ("failure", "why not", "left"),
    )
]


def shot_pages(desk: Desk) -> None:
    """Register `/shots` and `/shots/{shot}`."""

    @ui.page("/shots")
    def shots() -> None:
        with sheet(desk, "Shots", "/shots"), ui.element("div").classes("panel"):
            ui.label("Shots").classes("title")
            shot_table(latest(desk, None))

    @ui.page("/shots/{shot}")
    def one(shot: str, frame: int | None = None, effects: str | None = None) -> None:
        with sheet(desk, f"Shot {shot}", "/shots"):
            try:
                desk.daemon.store.shot(shot)
            except RigError as error:
                ui.label(error.sentence()).classes("verdict bad")
                ui.link("All shots", "/shots")
                return
            added = None if effects is None else tuple(filter(None, effects.split(",")))
            _OneShot(desk, shot, frame, added)


def latest(desk: Desk, campaign: str | None) -> list[ShotRecord]:
    """Return the latest shots, of one campaign or of all, the last first."""
    after = None
    found: list[ShotRecord] = []
    while page := desk.daemon.store.shots(campaign=campaign, limit=MOST_LISTED, after=after):
        found, after = [*found, *page][-MOST_LISTED:], page[-1].id
    return found[::-1]


def shot_table(shots: list[ShotRecord]) -> None:
    """Place a table of shots with a filter; a click opens one."""
    if not shots:
        ui.label("No shot has been fired yet: arm and fire one on the page Rig.").classes("empty")
        return
    given = ui.input("Filter").props("outlined dense clearable data-testid=filter")
    table = ui.table(rows=[_row(shot) for shot in shots], columns=COLUMNS, pagination=20)
    table.props("dense flat data-testid=shots").classes("wide").bind_filter_from(given, "value")

    def open_one(event: events.GenericEventArguments) -> None:
        ui.navigate.to(f"/shots/{event.args[1]['id']}")

    table.on("rowClick", open_one)


def _row(shot: ShotRecord) -> dict[str, object]:
    return {
        "id": shot.id,
        "number": shot.number,
        "state": str(shot.state).replace("_", " "),
        "campaign": shot.campaign or "",
        "pressure_a": shot.settings.pressure_a_kpa,
        "pressure_b": shot.settings.pressure_b_kpa,
        "offset": shot.settings.offset_mm,
        "at": f"{shot.accepted_at.astimezone():%Y-%m-%d %H:%M:%S}",
        "failure": shot.failure or "",
    }


class _OneShot:
    """One shot; drawn anew when it gets further."""

    def __init__(
        self, desk: Desk, shot: str, frame: int | None, effects: tuple[str, ...] | None
    ) -> None:
        self._desk, self._shot, self._frame, self._effects = desk, shot, frame, effects
        self._seen = self._stands()
        self._show()
        ui.timer(TICK_S * 3, self._follow)

    @ui.refreshable_method
    def _show(self) -> None:
        shot = self._desk.daemon.store.shot(self._shot)
        result = result_of(self._desk, shot)
        with ui.element("div").classes("columns shot"):
            with ui.element("div").classes("panel"):
                with ui.element("div").classes("title"):
                    ui.label(f"Shot {shot.number}")
                    ui.label(f"{shot.state}, {words(shot.settings)}").classes("aside")
                film(self._desk, shot, result, start=self._frame, keys=True)
            with ui.element("div").classes("stack"):
                with ui.element("div").classes("panel"):
                    ui.label("Coefficients").classes("title")
                    coefficients(shot, result)
                    again = button("Analyse again", self._again, testid="analyse-again")
                    again.set_enabled(shot.state in ENDED)
                    again.tooltip("a further result is added; none is replaced")
                ShotResiduals(self._desk, shot, self._effects)
                _record(shot)
                _notes(result.get("notes", []))

    def _again(self) -> None:
        self._desk.daemon.analyse(self._shot)
        ui.notify("Its analysis is queued.")

    def _stands(self) -> object:
        shot = self._desk.daemon.store.shot(self._shot)
        return shot.state, shot.results

    def _follow(self) -> None:
        stands = self._stands()
        if stands != self._seen:
            self._seen = stands
            self._show.refresh()


def _record(shot: ShotRecord) -> None:
    lines = [
        Line(["fired", str(shot.fired)]),
        Line(["campaign", shot.campaign or "none"]),
        Line(["simulated", "yes" if shot.simulated else "no, real"]),
        Line(["frames", "none" if shot.frames is None else f"{shot.frames}, {shot.lost} lost"]),
        Line(["results", str(shot.results)]),
        Line(["by", shot.actor]),
    ]
    with ui.element("div").classes("panel"):
        ui.label("Record").classes("title")
        facts([], lines)


def _notes(notes: list[str]) -> None:
    if notes:
        with ui.element("div").classes("panel"):
            ui.label("What the analysis left out").classes("title")
            for note in notes:
                ui.label(note).classes("note")
