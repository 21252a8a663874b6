"""Step 2 of the story: what the error goes with; a cell moves the plot, a point moves the film."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from nicegui import events, ui

from analysis.model.verdict.standing import SURE
from rigctl.documents import Json
from rigctl.page.model.compare import parsed
from rigctl.page.model.state import ModelState
from rigctl.page.model.story.bars import Bar, bars
from rigctl.page.model.story.plots import cell_plot
from rigctl.page.model.story.words import channel, goes_with, where
from rigctl.page.model.where import apart, block_of
from rigctl.page.parts.widgets import plot

CELLS = 6
PLACES = {"at the bounce": "contact", "in the air": "flight", "in the camera": "camera"}
"""Parts of the way in which cells are disturbed, by the words of the effects that act there."""


class Cells:
    """The cells of one answer, ordered by how much they show; `at` is the place of the chosen one.

    Attributes
    ----------
    listed
        Those that are offered, at most `CELLS`.
    """

    def __init__(self, cells: Sequence[Json]) -> None:
        self._all = cells
        self.listed = list(cells[:CELLS])
        self.at = 0

    @property
    def chosen(self) -> Json | None:
        """The cell whose points are drawn; None where there are none."""
        return self.listed[self.at] if self.listed else None

    def look_at(self, place: str) -> bool:
        """Choose the first cell of one of `PLACES`, listed or not; say whether it has one."""
        first = next((cell for cell in self._all if block_of(cell) == PLACES[place]), None)
        if first is None:
            return False
        self.listed = [first, *(cell for cell in self.listed if cell is not first)][:CELLS]
        self.at = 0
        return True


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
        self._cells = Cells(())

    def take(self, cells: Sequence[Json]) -> None:
        """Look at the cells of another answer, the most striking one first."""
        self._cells = Cells(cells)

    def look_at(self, place: str) -> None:
        """Look at the most striking cell of one of `PLACES`."""
        if self._cells.look_at(place):
            self.place.refresh()

    @ui.refreshable_method
    def place(self) -> None:
        """Place sentence, plot and cells."""
        cell = self._cells.chosen
        if cell is None:
            return
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
                listed = self._cells.listed
                most = max(own["deviation"] for own in listed)
                bars([_bar(own, most) for own in listed], self._choose, self._cells.at)

    def _choose(self, place: int) -> None:
        self._cells.at = place
        self.place.refresh()

    def _on_point(self, event: events.GenericEventArguments) -> None:
        points = event.args.get("points") if isinstance(event.args, dict) else None
        shot = points[0].get("customdata") if points else None
        if shot is not None:
            self._to_film(int(shot))


def _bar(cell: Json, most: float) -> Bar:
    return Bar(
        f"{channel(cell['channel'])}, {goes_with(cell)}",
        cell["deviation"] / max(most, 1e-9),
        f"{cell['deviation']:.0f} σ",
        fails=cell["p_familywise"] < SURE,
    )
