"""The steps of a sweep and what became of each, as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from nicegui import events, ui

from rigctl.store import ShotRecord, ShotState, StepRecord, StepState

COLUMNS: list[dict[str, Any]] = [
    {"name": name, "label": label, "field": name, "sortable": True, "align": align}
    for name, label, align in (
        ("step", "step", "right"),
        ("fate", "what became of it", "left"),
        ("pressure", "pressure a, kPa", "right"),
        ("offset", "offset, mm", "right"),
        ("shot", "shot", "right"),
        ("why", "why not", "left"),
    )
]


def what_became(step: StepRecord, shot: ShotRecord | None) -> str:
    """Return the fate of a step as the plots name it: a key of `sweep_plots.LOOKS`."""
    if step.state is StepState.WAITING:
        return "waits"
    if step.state is StepState.SKIPPED:
        return "skipped"
    if step.state is StepState.TAKEN:
        return "under way"
    if step.state is StepState.STORED and shot is not None:
        fates = {ShotState.ANALYSED: "measured", ShotState.REFUSED: "not measured"}
        return fates.get(shot.state, "under way")
    return "not measured"


def steps_table(steps: Sequence[StepRecord], shots: Mapping[str, ShotRecord]) -> None:
    """Place the steps in the order of firing; a click opens a step's shot."""
    rows = [_row(step, shots.get(step.shot or "")) for step in steps]
    table = ui.table(rows=rows, columns=COLUMNS, pagination=8, row_key="step")
    table.props("dense flat data-testid=steps").classes("wide")

    def open_shot(event: events.GenericEventArguments) -> None:
        if name := event.args[1]["id"]:
            ui.navigate.to(f"/shots/{name}")

    table.on("rowClick", open_shot)


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
