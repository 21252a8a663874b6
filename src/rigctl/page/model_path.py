"""Step 4: the error path, which grows with every effect that is added."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from rigctl.page.model_state import Effects, ModelState
from rigctl.page.plots import error_path
from rigctl.page.quantities import ERROR
from rigctl.page.widgets import button, plot, save_csv

SAMPLING_ERRORS = 2.0


def grown_path(state: ModelState, take: Callable[[Effects], None]) -> None:
    """Place the plot of the error on shots left out; `take` goes back to earlier effects."""
    path = state.path()
    errors = [stage["prediction_error"] for stage in path]
    bars = [SAMPLING_ERRORS * stage["prediction_error_sampling"] for stage in path]
    labels = ["base model", *(f"+ {name}" for name in state.effects)][: len(path)]
    with ui.element("div").classes("panel").props("data-testid=error-path"):
        with ui.element("div").classes("title"):
            ui.label("4").classes("step")
            ui.label("Error path")
            ui.label("error on shots left out; green: the floor").classes("aside").tooltip(ERROR)
            ui.space()
            rows = [["stage", "error", "chi2_per_dof"]]
            rows += [
                [label, stage["prediction_error"], stage["chi2_per_dof"]]
                for label, stage in zip(labels, path, strict=True)
            ]
            save_csv(f"{state.source.title}-error-path", lambda: rows)
            undo = button("Undo", lambda: take(state.effects[:-1]), testid="undo")
            undo.set_enabled(bool(state.effects))
        plot(error_path(labels, errors, bars))
        if not state.effects:
            ui.label("Add an effect in step 3: the path grows and shows what it brings.").classes(
                "note"
            )
