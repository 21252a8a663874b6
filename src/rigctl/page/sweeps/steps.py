"""The steps of a sweep and what became of each, as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from nicegui import events, ui

from rigctl.page.shots.table import WHY, column, explain_headings
from rigctl.store import ShotRecord, ShotState, StepRecord, StepState

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

    `shot` is None also where it was not read yet.
    """
    if step.state is StepState.WAITING:
        return "waits"
    if step.state is StepState.SKIPPED:
        return "skipped"
    if step.state is StepState.TAKEN:
        return "under way"
    if step.state is StepState.STORED:
        fates = {ShotState.ANALYSED: "measured", ShotState.REFUSED: "not measured"}
        return "fired" if shot is None else fates.get(shot.state, "under way")
    return "not measured"


class StepsTable:
    """The steps in the order of firing, placed where it is made; a click opens a step's shot."""

    def __init__(self) -> None:
        self._table = ui.table(rows=[], columns=COLUMNS, pagination=8, row_key="step")
        self._table.props("dense flat data-testid=steps").classes("wide")
        self._table.on("rowClick", _open_shot)
        explain_headings(self._table)

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
