"""Sweeps: built with a preview of what they cover, started, watched, paused, resumed, given up."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from rigctl.page.desk import Desk, actor
from rigctl.page.layout import TICK_S, sheet
from rigctl.page.sweep_form import SweepForm
from rigctl.page.widgets import button
from rigctl.store import StepState, SweepState
from rigctl.sweeps.status import SweepStatus

SHOWN = 12
ENDED = frozenset({StepState.WAITING, StepState.TAKEN})
"""States of steps that are still to come to an end."""


def sweep_pages(desk: Desk) -> None:
    """Register `/sweeps`."""

    @ui.page("/sweeps")
    def sweeps() -> None:
        with sheet(desk, "Sweeps", "/sweeps"), ui.element("div").classes("columns sweep"):
            form = SweepForm(desk)
            with ui.element("div").classes("stack"):
                form.preview()
                _Running(desk)


class _Running:
    """The sweeps, the latest first; drawn anew when one of them gets further."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._seen: list[SweepStatus] = self._stand()
        with ui.element("div").classes("panel").props("data-testid=sweeps"):
            ui.label("Sweeps").classes("title")
            self._show()
        ui.timer(TICK_S * 5, self._follow)

    def _stand(self) -> list[SweepStatus]:
        found = self._desk.daemon.store.sweeps.sweeps(limit=SHOWN)
        return [self._desk.daemon.sweeps.status(record.id) for record in found]

    def _follow(self) -> None:
        stand = self._stand()
        if stand != self._seen:
            self._seen = stand
            self._show.refresh()

    @ui.refreshable_method
    def _show(self) -> None:
        if not self._seen:
            ui.label("No sweep has been run yet. Choose ranges on the left, then Start.").classes(
                "empty"
            )
        for status in self._seen:
            self._one(status)

    def _one(self, status: SweepStatus) -> None:
        record = status.record
        left = sum(count for state, count in record.counts.items() if state in ENDED)
        done = record.steps - left
        with ui.element("div").classes("wide"):
            with ui.element("div").classes("beside"):
                ui.label(record.id).classes("title")
                ui.label(f"{record.state}, {done} of {record.steps} shots{_left(status)}")
                if record.campaign:
                    ui.link(record.campaign, f"/campaigns/{record.campaign}")
                ui.space()
                self._orders(status)
            ui.linear_progress(done / max(record.steps, 1), show_value=False, size="8px").props(
                f'rounded aria-label="{done} of {record.steps}"'
            )
            ui.label(record.reason).classes("note")

    def _orders(self, status: SweepStatus) -> None:
        sweep, runner = status.record.id, self._desk.daemon.sweeps
        if status.asked is not None:
            ui.label(f"{status.asked} asked; the shot under way ends first").classes("aside")
            return
        if status.record.state is SweepState.RUNNING:
            button("Pause", lambda: self._order(runner.pause, sweep), testid="pause")
        if status.record.state is SweepState.PAUSED:
            button(
                "Resume", lambda: self._order(runner.resume, sweep), look="fill", testid="resume"
            )
        if status.record.state in {SweepState.RUNNING, SweepState.PAUSED}:
            button("Abort", lambda: self._order(runner.abort, sweep), testid="abort")

    async def _order(self, order: Callable[[str, str], SweepStatus], sweep: str) -> None:
        who = actor()
        await self._desk.act(lambda: order(sweep, who))
        self._follow()


def _left(status: SweepStatus) -> str:
    if status.left_s is None:
        return ""
    return (
        f", {status.left_s / 60:.0f} min left"
        if status.left_s > 90
        else (f", {status.left_s:.0f} s left")
    )
