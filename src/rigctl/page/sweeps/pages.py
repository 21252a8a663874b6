"""Sweeps: built with a preview of what they cover, listed, and one that is watched."""

from __future__ import annotations

from nicegui import ui

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S, sheet
from rigctl.page.parts.following import following
from rigctl.page.parts.presence import kept_page
from rigctl.page.sweeps.form import SweepForm
from rigctl.page.sweeps.orders import SweepProgress
from rigctl.page.sweeps.view import SweepView
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
    """The sweeps, the latest first; each is updated in place when it gets further."""

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
        if self._heard == self._desk.feed.told or (stand := self._stand()) == self._seen:
            return
        before, self._seen = self._seen, stand
        if _names(before) != _names(stand):
            self._show.refresh()
            return
        for placed, status in zip(self._placed, stand, strict=True):
            placed.show(status)

    @ui.refreshable_method
    def _show(self) -> None:
        if not self._seen:
            ui.label("No sweep has been run yet. Choose ranges, then Start.").classes("empty")
        self._placed = [self._one(status) for status in self._seen]

    def _one(self, status: SweepStatus) -> SweepProgress:
        name = status.record.id

        def title() -> None:
            ui.link(name, f"/sweeps/{name}").classes("strong")

        with ui.element("div").classes("wide entry"):
            return SweepProgress(self._desk, status, title)


def _names(shown: list[SweepStatus]) -> list[str]:
    return [status.record.id for status in shown]
