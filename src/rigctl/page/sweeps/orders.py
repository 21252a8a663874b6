"""What can be ordered of a sweep (pause, resume, abort), beside how far it is."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from rigctl.page.desk import Desk, actor
from rigctl.page.parts.asking import ask_again
from rigctl.page.parts.widgets import button
from rigctl.store import StepState, SweepState
from rigctl.sweeps.status import SweepStatus

TO_COME = frozenset({StepState.WAITING, StepState.TAKEN})
"""States of steps that are still to come to an end."""


class SweepProgress:
    """State, buttons, bar and reason of a sweep, updated in place.

    A button is replaced only when other orders become possible: a click on one that is replaced
    meanwhile would be lost.

    Parameters
    ----------
    desk
        What the page works on.
    status
        The sweep as it is first shown.
    title
        Places what names the sweep, before everything else.
    """

    def __init__(self, desk: Desk, status: SweepStatus, title: Callable[[], None]) -> None:
        self._desk, self._status = desk, status
        record = status.record
        with ui.element("div").classes("head"):
            title()
            self._said = ui.label().props("data-testid=sweep-state role=status")
            if record.campaign:
                ui.link(f"campaign {record.campaign}", f"/campaigns/{record.campaign}")
            ui.space()
            self._orders()
        self._bar = ui.linear_progress(0.0, show_value=False, size="8px").props("rounded")
        self._reason = ui.label().classes("note")
        self._draw()

    def show(self, status: SweepStatus) -> None:
        """Show the sweep as it is now."""
        before, self._status = self._status, status
        if (before.record.state, before.asked) != (status.record.state, status.asked):
            self._orders.refresh()
        self._draw()

    def _draw(self) -> None:
        record = self._status.record
        done, steps, said = how_far(self._status)
        self._said.set_text(f"{record.state}, {said}")
        self._bar.set_value(done / max(steps, 1))
        self._bar.props(f'aria-label="{said}"')
        self._reason.set_text(record.reason)

    @ui.refreshable_method
    def _orders(self) -> None:
        sweep, runner = self._status.record.id, self._desk.daemon.sweeps
        state = self._status.record.state

        async def order(what: Callable[[str, str], SweepStatus], *, moves: bool = False) -> None:
            who = actor()
            await self._desk.act(lambda: what(sweep, who), moves=moves)

        if self._status.asked is not None:
            ui.label(f"{self._status.asked} asked; the shot under way ends first").classes("aside")
            return
        if state is SweepState.RUNNING:
            button("Pause", lambda: order(runner.pause), testid="pause")
        if state is SweepState.PAUSED:
            button("Resume", lambda: order(runner.resume, moves=True), look="fill", testid="resume")
        if state in {SweepState.RUNNING, SweepState.PAUSED}:
            button("Abort …", lambda: self._ask_abort(order), testid="abort")

    def _ask_abort(
        self, order: Callable[[Callable[[str, str], SweepStatus]], Awaitable[None]]
    ) -> None:
        done, steps, _ = how_far(self._status)
        ask_again(
            f"Abort sweep {self._status.record.id}",
            f"{steps - done} of {steps} shots are left and would never be fired; the shot under "
            "way ends first, and what was fired stays. A paused sweep can go on instead.",
            "Abort",
            lambda: order(self._desk.daemon.sweeps.abort),
        )


def how_far(status: SweepStatus) -> tuple[int, int, str]:
    """Return steps that had their turn, all steps, and the same in words with the time left."""
    record = status.record
    skipped = record.counts.get(StepState.SKIPPED, 0)
    done = record.steps - skipped - sum(record.counts.get(state, 0) for state in TO_COME)
    without = f", {skipped} skipped" if skipped else ""
    return done, record.steps, f"{done} of {record.steps} shots{without}{_left(status.left_s)}"


def _left(seconds: float | None) -> str:
    if seconds is None:
        return ""
    return f", {seconds / 60:.0f} min left" if seconds > 90 else f", {seconds:.0f} s left"
