"""Sweeps: built with a preview of what they cover, listed, and one that is watched."""

from __future__ import annotations

from nicegui import ui

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.following import following
from rigctl.page.layout import TICK_S, sheet
from rigctl.page.presence import kept_page
from rigctl.page.sweep_form import SweepForm
from rigctl.page.sweep_orders import bar, how_far, orders
from rigctl.page.sweep_view import SweepView
from rigctl.sweeps.status import SweepStatus

SHOWN = 12


def sweep_pages(desk: Desk) -> None:
    """Register `/sweeps` and `/sweeps/{sweep}`."""

    @kept_page("/sweeps")
    def sweeps(form: str = "") -> None:
        with sheet(desk, "Sweeps", "/sweeps"), ui.element("div").classes("columns sweep"):
            placed = SweepForm(desk, form)
            with ui.element("div").classes("stack"):
                placed.preview()
                _Listed(desk)

    @kept_page("/sweeps/{sweep}")
    def one(sweep: str) -> None:
        with sheet(desk, f"Sweep {sweep}", "/sweeps"):
            try:
                desk.daemon.sweeps.status(sweep)
            except RigError as error:
                ui.label(error.sentence()).classes("verdict bad")
                ui.link("All sweeps", "/sweeps")
                return
            SweepView(desk, sweep)


class _Listed:
    """The sweeps, the latest first; drawn anew when one of them gets further."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._seen: list[SweepStatus] = self._stand()
        with ui.element("div").classes("panel").props("data-testid=sweeps"):
            ui.label("Sweeps").classes("title")
            self._show()
        following(TICK_S * 5, self._follow)

    def _stand(self) -> list[SweepStatus]:
        self._heard = self._desk.feed.told
        found = self._desk.daemon.store.sweeps.sweeps(limit=SHOWN)
        return [self._desk.daemon.sweeps.status(record.id) for record in found]

    def _follow(self) -> None:
        if self._heard != self._desk.feed.told and (stand := self._stand()) != self._seen:
            self._seen = stand
            self._show.refresh()

    @ui.refreshable_method
    def _show(self) -> None:
        if not self._seen:
            ui.label("No sweep has been run yet. Choose ranges, then Start.").classes("empty")
        for status in self._seen:
            self._one(status)

    def _one(self, status: SweepStatus) -> None:
        record = status.record
        with ui.element("div").classes("wide entry"):
            with ui.element("div").classes("beside"):
                ui.link(record.id, f"/sweeps/{record.id}").classes("strong")
                ui.label(f"{record.state}, {how_far(status)[2]}")
                if record.campaign:
                    ui.link(record.campaign, f"/campaigns/{record.campaign}")
                ui.space()
                orders(self._desk, status)
            bar(status)
            ui.label(record.reason).classes("note")
