"""Sweeps: built with a preview of what they cover, listed, and one that is watched."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass

from nicegui import events, run, ui

from rigctl.errors import RigError
from rigctl.page.desk import Desk, actor
from rigctl.page.layout import TICK_S, sheet
from rigctl.page.parts.asking import ask_again
from rigctl.page.parts.empty_plots import NONE_OF_SWEEP, READING
from rigctl.page.parts.following import following
from rigctl.page.parts.impact_plots import over_incidence, over_speed
from rigctl.page.parts.presence import kept_page
from rigctl.page.parts.quantities import INCIDENCE, SPEED
from rigctl.page.parts.readings import Impact, rows_of
from rigctl.page.parts.widgets import button, plot, save_csv
from rigctl.page.shots.table import WHY, column, explain_headings, link_cells
from rigctl.page.sweeps.form import SweepForm
from rigctl.page.sweeps.plots import MEASURES, legend, progress
from rigctl.settings import ShotSettings
from rigctl.store import ShotRecord, ShotState, StepRecord, StepState, SweepState
from rigctl.sweeps.status import SweepStatus

COLUMNS = [
    column("step", "step"),
    column("fate", "what became of it", "left"),
    column("pressure", "pressure a, kPa"),
    column("offset", "offset, mm"),
    column("shot", "shot"),
    column("why", "why not", "left", **WHY),
]


def what_became(step: StepRecord, shot: ShotRecord | None) -> str:
    """Return the fate of a step as the plots name it: a key of `sweep_plots.LOOKS`.

    `shot` is None also where it was not read yet. What was fired is being measured until it is.
    """
    if step.state is StepState.WAITING:
        return "waiting"
    if step.state is StepState.SKIPPED:
        return "skipped"
    if step.state is StepState.TAKEN:
        return "being fired"
    if step.state is StepState.STORED:
        fates = {ShotState.ANALYSED: "measured", ShotState.REFUSED: "not measured"}
        return MEASURES if shot is None else fates.get(shot.state, MEASURES)
    return "not measured"


class StepsTable:
    """The steps in the order of firing, placed where it is made; a click opens a step's shot."""

    def __init__(self) -> None:
        self._table = ui.table(rows=[], columns=COLUMNS, pagination=8, row_key="step")
        self._table.props("dense flat data-testid=steps").classes("wide")
        self._table.on("rowClick", _open_shot)
        explain_headings(self._table)
        link_cells(self._table, "shot", "/shots/", "id")

    def show(self, steps: Sequence[StepRecord], shots: Mapping[str, ShotRecord]) -> None:
        """Show steps with their shots, by the shots' names."""
        self._table.rows = [_row(step, shots.get(step.shot or "")) for step in steps]


def _open_shot(event: events.GenericEventArguments) -> None:
    if name := event.args[1]["id"]:
        ui.navigate.to(f"/shots/{name}")


def _row(step: StepRecord, shot: ShotRecord | None) -> dict[str, object]:
    why = step.failure or (shot.failure if shot is not None else None)
    return {
        "id": step.shot or "",
        "step": step.number,
        "fate": what_became(step, shot),
        "pressure": round(step.settings.pressure_a_kpa, 2),
        "offset": round(step.settings.offset_mm, 3),
        "shot": "" if shot is None else shot.number,
        "why": why or "",
    }


SETTLED = frozenset({ShotState.MISFIRE, ShotState.UNKNOWN_OUTCOME, ShotState.ABORTED})


@dataclass(frozen=True, slots=True)
class _Stand:
    """A sweep at one moment, with its shots by their names and what they were measured to be."""

    status: SweepStatus
    steps: list[StepRecord]
    shots: Mapping[str, ShotRecord]
    impacts: list[Impact]


class SweepView:
    """Placed where it is made; follows the sweep."""

    def __init__(self, desk: Desk, sweep: str) -> None:
        self._desk, self._sweep = desk, sweep
        self._limits = desk.daemon.configuration.limits
        self._heard = -1
        # What is planned is there at once; what the shots were measured to be takes a disk.
        steps = desk.daemon.store.sweeps.steps(sweep)
        self._now = _Stand(desk.daemon.sweeps.status(sweep), steps, {}, [])
        with ui.element("div").classes("panel").props("data-testid=sweep"):
            self._progress = SweepProgress(desk, self._now.status, self._heading)
        with ui.element("div").classes("columns third"):
            with ui.element("div").classes("panel"):
                ui.label("Where it is").classes("title")
                self._legend = ui.html(self._counted(), sanitize=False).props("data-testid=legend")
                self._plane = plot(progress(self._by_fate(), self._limits))
            with ui.element("div").classes("panel"):
                self._titled("Bounce over approach speed", "restitution", SPEED)
                self._speed = plot(over_speed([], sweep, READING)).props("data-testid=grows")
            with ui.element("div").classes("panel"):
                self._titled("Spin-back over sliding", "tangential", INCIDENCE)
                self._incidence = plot(over_incidence([], sweep, READING))
        with ui.element("div").classes("panel"):
            ui.label("Steps").classes("title")
            self._table = StepsTable()
            self._table.show(steps, {})
        following(TICK_S * 3, self._follow)

    async def _follow(self) -> None:
        heard = self._desk.feed.told
        if heard == self._heard:
            return
        stand = await run.io_bound(self._stand)
        if stand is None:
            return
        first = self._heard < 0
        self._heard, before, self._now = heard, self._now, stand
        if stand.status != before.status:
            self._progress.show(stand.status)
        if stand.steps != before.steps or stand.shots != before.shots:
            self._table.show(stand.steps, stand.shots)
            self._plane.update_figure(progress(self._by_fate(), self._limits))
            self._legend.set_content(self._counted())
        if first or stand.impacts != before.impacts:
            told = stand.impacts, self._sweep, NONE_OF_SWEEP
            self._speed.update_figure(over_speed(*told))
            self._incidence.update_figure(over_incidence(*told))

    def _stand(self) -> _Stand:
        """Read the sweep; blocks for the disk. A shot that has ended is not read again."""
        status = self._desk.daemon.sweeps.status(self._sweep)
        store = self._desk.daemon.store
        steps = store.sweeps.steps(self._sweep)
        shots = {
            step.shot: store.shot(step.shot)
            for step in steps
            if step.shot is not None and step.shot not in self._ended()
        }
        shots = {**self._ended(), **shots}
        return _Stand(status, steps, shots, self._desk.readings.of(shots.values()))

    def _ended(self) -> dict[str, ShotRecord]:
        ended = {ShotState.ANALYSED, ShotState.REFUSED, *SETTLED}
        return {name: shot for name, shot in self._now.shots.items() if shot.state in ended}

    def _by_fate(self) -> dict[str, list[tuple[int, ShotSettings]]]:
        found: dict[str, list[tuple[int, ShotSettings]]] = {}
        for step in self._now.steps:
            fate = what_became(step, self._now.shots.get(step.shot or ""))
            found.setdefault(fate, []).append((step.number, step.settings))
        return found

    def _counted(self) -> str:
        return legend({fate: len(steps) for fate, steps in self._by_fate().items()})

    def _heading(self) -> None:
        ui.html(f"<h2>Sweep {self._sweep}</h2>", sanitize=False)

    def _titled(self, title: str, name: str, meaning: str) -> None:
        with ui.element("div").classes("title"):
            ui.label(title).tooltip(meaning)
            ui.space()
            save_csv(f"{self._sweep}-{name}", lambda: rows_of(self._now.impacts))


SHOWN = 12
CHOOSE = "Choose ranges, then Start."


def sweep_pages(desk: Desk) -> None:
    """Register `/sweeps` and `/sweeps/{sweep}`."""

    @kept_page("/sweeps")
    def sweeps(form: str = "") -> None:
        with sheet(desk, "Sweeps", "/sweeps"), ui.element("div").classes("columns sweep"):
            placed = SweepForm(desk, form)
            with ui.element("div").classes("stack"):
                placed.preview()
                _Listed(desk, first="Press Start." if placed.is_proposed else CHOOSE)

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
    """The sweeps, the latest first; each is updated in place when it gets further.

    `first` says what to do before there is one.
    """

    def __init__(self, desk: Desk, first: str) -> None:
        self._desk, self._first = desk, first
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
            ui.label(f"No sweep has been run yet. {self._first}").classes("empty")
        self._placed = [self._one(status) for status in self._seen]

    def _one(self, status: SweepStatus) -> SweepProgress:
        name = status.record.id

        def title() -> None:
            ui.link(name, f"/sweeps/{name}").classes("strong")

        with ui.element("div").classes("wide entry"):
            return SweepProgress(self._desk, status, title)


def _names(shown: list[SweepStatus]) -> list[str]:
    return [status.record.id for status in shown]


TO_COME = frozenset({StepState.WAITING, StepState.TAKEN})
"""States of steps that are still to come to an end."""


class SweepProgress:
    """State, buttons (pause, resume, abort), bar and reason of a sweep, updated in place.

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
    given_up = record.counts.get(StepState.NOT_FIRED, 0)
    not_fired = f", {given_up} could not be" if given_up else ""
    fired = f"{done - given_up} of {record.steps} shots fired"
    said = f"{fired}{not_fired}{without}{_left(status.left_s)}"
    return done, record.steps, said


def _left(seconds: float | None) -> str:
    if seconds is None:
        return ""
    return f", {seconds / 60:.0f} min left" if seconds > 90 else f", {seconds:.0f} s left"
