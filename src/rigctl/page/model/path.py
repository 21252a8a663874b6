"""Step 4: the error path, which grows with every effect that is added."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from rigctl.page.model.state import Effects, ModelState
from rigctl.page.parts.plots import error_path
from rigctl.page.parts.quantities import ERROR
from rigctl.page.parts.widgets import button, plot, redraw, save_csv

SAMPLING_ERRORS = 2.0


class GrownPath:
    """The plot of the error on shots left out; `take` goes back to earlier effects."""

    def __init__(self, state: ModelState, take: Callable[[Effects], None]) -> None:
        self._state = state
        with ui.element("div").classes("panel").props("data-testid=error-path"):
            with ui.element("div").classes("title"):
                ui.label("4").classes("step")
                ui.label("Error path")
                ui.label("error on shots left out; green: the floor").classes("aside").tooltip(
                    ERROR
                )
                ui.space()
                save_csv(f"{state.source.title}-error-path", self._rows)
                self._undo = button("Undo", lambda: take(state.effects[:-1]), testid="undo")
            self._plot = plot(self._figure())
            self._note = ui.label(
                "Add an effect in step 3: the path grows and shows what it brings."
            ).classes("note")
        self._enable()

    def show(self) -> None:
        """Draw the path to the present effects, as far as it is known."""
        figure = self._figure()
        if figure != self._plot.figure:
            redraw(self._plot, figure)
        self._enable()

    def _enable(self) -> None:
        self._undo.set_enabled(bool(self._state.effects))
        self._note.set_visibility(not self._state.effects)

    def _labels(self) -> list[str]:
        known = len(self._state.path())
        return ["base model", *(f"+ {name}" for name in self._state.effects)][:known]

    def _figure(self) -> dict[str, Any]:
        path = self._state.path()
        errors = [stage["prediction_error"] for stage in path]
        bars = [SAMPLING_ERRORS * stage["prediction_error_sampling"] for stage in path]
        return error_path(self._labels(), errors, bars)

    def _rows(self) -> list[list[object]]:
        rows: list[list[object]] = [["stage", "error", "chi2_per_dof"]]
        stages = zip(self._labels(), self._state.path(), strict=True)
        return rows + [
            [label, stage["prediction_error"], stage["chi2_per_dof"]] for label, stage in stages
        ]
