"""Step 2 of the story: what the error goes with; a cell moves the plot, a point moves the film."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from nicegui import events, ui

from analysis.model.verdict.standing import SURE
from rigctl.page.model.compare import parsed
from rigctl.page.model.state import ModelState
from rigctl.page.model.story.bars import Bar, bars
from rigctl.page.model.story.plots import cell_plot
from rigctl.page.model.story.words import channel, goes_with, where
from rigctl.page.model.where import apart
from rigctl.page.parts.widgets import plot

Json = dict[str, Any]
CELLS = 6


class WhereItFails:
    """The cells in which the error shows most, and the points of the one that is looked at.

    Parameters
    ----------
    to_film
        Called with the number of the shot whose point was clicked.
    filmed
        Returns the number of the shot whose film is shown; None where none is.
    """

    def __init__(
        self, state: ModelState, to_film: Callable[[int], None], filmed: Callable[[], int | None]
    ) -> None:
        self._state, self._to_film, self._filmed = state, to_film, filmed
        self._cells: Sequence[Json] = ()
        self._at = 0

    def take(self, cells: Sequence[Json]) -> None:
        """Look at the cells of another answer, the most striking one first."""
        self._cells, self._at = cells[:CELLS], 0

    @ui.refreshable_method
    def place(self) -> None:
        """Place sentence, plot and cells."""
        if not self._cells:
            return
        cell = self._cells[self._at]
        points = parsed(cell["points"])
        trend = points["trend"]
        said = where(cell, points, self._state.standing)
        ui.label(said).classes("lede").props("data-testid=story-where")
        with ui.element("div").classes("columns where"):
            with ui.element("div").classes("stack"):
                curve = (trend["x"], trend["mean"])
                drawn = plot(cell_plot(cell, apart(points), curve, self._filmed()))
                drawn.on("plotly_click", self._on_point).props("data-testid=story-points")
                ui.label("Click a dot: the film above shows its shot, ringed here.").classes("note")
            with ui.element("div").classes("stack"):
                ui.label("What the error goes with, and how surely").classes("strong")
                bars([self._bar(k) for k in range(len(self._cells))], self._choose, self._at)

    def _bar(self, place: int) -> Bar:
        cell = self._cells[place]
        return Bar(
            f"{channel(cell['channel'])}, {goes_with(cell)}",
            cell["deviation"] / max(self._cells[0]["deviation"], 1e-9),
            f"{cell['deviation']:.0f} σ",
            fails=cell["p_familywise"] < SURE,
        )

    def _choose(self, place: int) -> None:
        self._at = place
        self.place.refresh()

    def _on_point(self, event: events.GenericEventArguments) -> None:
        points = event.args.get("points") if isinstance(event.args, dict) else None
        shot = points[0].get("customdata") if points else None
        if shot is not None:
            self._to_film(int(shot))
