"""What can be ordered of a sweep: pause, resume, abort."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from rigctl.page.desk import Desk, actor
from rigctl.page.widgets import button
from rigctl.store import StepState, SweepState
from rigctl.sweeps.status import SweepStatus

TO_COME = frozenset({StepState.WAITING, StepState.TAKEN})
"""States of steps that are still to come to an end."""


def orders(desk: Desk, status: SweepStatus) -> None:
    """Place the buttons that a sweep's state allows; whoever shows it hears what came of them."""
    sweep, runner, state = status.record.id, desk.daemon.sweeps, status.record.state

    async def order(what: Callable[[str, str], SweepStatus], *, moves: bool = False) -> None:
        who = actor()
        await desk.act(lambda: what(sweep, who), moves=moves)

    if status.asked is not None:
        ui.label(f"{status.asked} asked; the shot under way ends first").classes("aside")
        return
    if state is SweepState.RUNNING:
        button("Pause", lambda: order(runner.pause), testid="pause")
    if state is SweepState.PAUSED:
        button("Resume", lambda: order(runner.resume, moves=True), look="fill", testid="resume")
    if state in {SweepState.RUNNING, SweepState.PAUSED}:
        button("Abort", lambda: order(runner.abort), testid="abort")


def how_far(status: SweepStatus) -> tuple[int, int, str]:
    """Return steps that had their turn, all steps, and the same in words with the time left."""
    record = status.record
    skipped = record.counts.get(StepState.SKIPPED, 0)
    done = record.steps - skipped - sum(record.counts.get(state, 0) for state in TO_COME)
    without = f", {skipped} skipped" if skipped else ""
    return done, record.steps, f"{done} of {record.steps} shots{without}{_left(status.left_s)}"


def bar(status: SweepStatus) -> None:
    """Place the bar of what is done."""
    done, steps, said = how_far(status)
    ui.linear_progress(done / max(steps, 1), show_value=False, size="8px").props(
        f'rounded aria-label="{said}"'
    )


def _left(seconds: float | None) -> str:
    if seconds is None:
        return ""
    return f", {seconds / 60:.0f} min left" if seconds > 90 else f", {seconds:.0f} s left"
