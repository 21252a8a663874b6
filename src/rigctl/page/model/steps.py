"""The four steps side by side: panels that stay, in which each answer is drawn."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.model.compare import compare
from rigctl.page.model.missing import missing
from rigctl.page.model.state import Effects, ModelState
from rigctl.page.model.where import Where
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


class Steps:
    """Compare, where it fails, what is missing, error path; nothing before the first answer.

    `take` has the model taken with other effects. `last` is where more can be placed after them.
    """

    def __init__(self, desk: Desk, state: ModelState, take: Callable[[Effects], None]) -> None:
        self._desk, self._state, self._take = desk, state, take
        self._shown: Json = {}
        self._due = False
        # In the order in which they are read: in rows, or in one column on a tablet.
        with ui.element("div").classes("columns model nothing") as self._all:
            self._first, self._second, self._offered = (ui.element("div") for _ in range(3))
            self.last = ui.element("div").classes("stack")
            with self.last:
                self._fourth = ui.element("div")
        self.show()

    def show(self) -> None:
        """Draw the latest answer on the way to the present effects."""
        known = self._state.path()
        if not known:
            return
        shown, before = self._state.present or known[-1], self._shown
        self._shown = shown
        if not before:
            self._build()
            return
        if shown is not before:
            self._compared.refresh()
            # A plot that is drawn over costs half of one that is made anew.
            self._where.show(shown)
            self._due = True
        self._path.show()
        self._hold()

    def rank(self) -> None:
        """Draw the ranking of the answer that `show` drew, once the browser has begun with that.

        It is a third of all that is drawn, and what was asked is answered above it.
        """
        if self._due:
            self._due = False
            self._ranked.refresh()
            self._hold()

    def _build(self) -> None:
        self._all.classes(remove="nothing")
        with self._first:
            self._compared()
        with self._second:
            self._where = Where(self._desk, self._state, self._shown)
        with self._offered:
            self._ranked()
        with self._fourth:
            self._path = GrownPath(self._state, self._take)
        self._hold()

    def _hold(self) -> None:
        """Let no effect be added from a ranking that is not that of the present effects."""
        waiting = self._due or self._state.present is None
        self._offered.props(add="inert" if waiting else None, remove=None if waiting else "inert")

    @ui.refreshable_method
    def _compared(self) -> None:
        compare(self._shown)

    @ui.refreshable_method
    def _ranked(self) -> None:
        missing(self._shown, self._add)

    def _add(self, name: str) -> None:
        self._take((*self._state.effects, name))
