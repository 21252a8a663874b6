"""Step 2 of the story: what the error goes with; a cell moves the plot, a point moves the film."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from nicegui import events, ui

from analysis.model.verdict.standing import SURE, Standing
from rigctl.documents import Json
from rigctl.page.model.compare import parsed
from rigctl.page.model.story.bars import Bar, bars
from rigctl.page.model.story.map import place_map
from rigctl.page.model.story.plots import cell_plot
from rigctl.page.model.story.words import channel, goes_with, where
from rigctl.page.model.where import apart, block_of
from rigctl.page.parts.widgets import button, plot, redraw

CELLS = 6
PLACES = {"at the bounce": "contact", "in the air": "flight", "in the camera": "camera"}
"""Parts of the way in which cells are disturbed, by the words of the effects that act there."""


class Cells:
    """The cells of one answer, ordered by how much they show; one is chosen.

    Attributes
    ----------
    chosen
        The cell whose points are drawn; None where there are none.
    """

    def __init__(self, cells: Sequence[Json]) -> None:
        self._all = list(cells)
        self.chosen: Json | None = self._all[0] if self._all else None

    @property
    def place(self) -> str:
        """The one of `PLACES` in which the chosen cell lies."""
        return next(name for name in PLACES if self._of(name) and self.chosen in self._of(name))

    @property
    def here(self) -> list[Json]:
        """The cells of the chosen one's place."""
        return self._of(self.place)

    @property
    def places(self) -> dict[str, Json]:
        """Each place that has cells, with the cell of it that shows most."""
        return {name: found[0] for name in PLACES if (found := self._of(name))}

    def look_at(self, place: str) -> bool:
        """Choose the first cell of one of `PLACES`; say whether it has one."""
        first = self.places.get(place)
        self.chosen = first or self.chosen
        return first is not None

    def _of(self, place: str) -> list[Json]:
        return [cell for cell in self._all if block_of(cell) == PLACES[place]]


class WhereItFails:
    """The cells in which the error shows most, and the points of the one that is looked at.

    Parameters
    ----------
    to_film
        Called with the number of the shot whose point was clicked.
    filmed
        Returns the number of the shot whose film is shown; None where none is.
    """

    def __init__(self, to_film: Callable[[int], None], filmed: Callable[[], int | None]) -> None:
        self._to_film, self._filmed = to_film, filmed
        self._cells = Cells(())
        self._standing: Standing | None = None

    def take(self, cells: Sequence[Json], standing: Standing) -> None:
        """Look at the cells of another answer, the most striking one first."""
        self._cells, self._standing = Cells(cells), standing

    def look_at(self, place: str) -> None:
        """Look at the most striking cell of one of `PLACES`."""
        if self._cells.look_at(place):
            self.place.refresh()

    @ui.refreshable_method
    def place(self) -> None:
        """Place sentence, map and plot."""
        if self._cells.chosen is None:
            return
        self._choice()
        self._told()
        with ui.element("div").classes("columns where"):
            with ui.element("div").classes("stack"):
                self._offer(self._cells.here, self._cells.chosen)
            with ui.element("div").classes("stack"):
                self._named = ui.label(self._name()).classes("strong")
                self._plot = plot(self._figure())
                self._plot.on("plotly_click", self._on_point).props("data-testid=story-points")
                ui.label("Click a dot: the film above shows its shot, ringed here.").classes("note")

    @ui.refreshable_method
    def _told(self) -> None:
        if (cell := self._cells.chosen) is not None:
            said = where(cell, parsed(cell["points"]), self._standing)
            ui.label(said).classes("lede").props("data-testid=story-where")

    def ring(self) -> None:
        """Ring the shot whose film is shown."""
        if self._cells.chosen is not None:
            redraw(self._plot, self._figure())

    def _name(self) -> str:
        cell = self._cells.chosen
        return "" if cell is None else f"{channel(cell['channel']).capitalize()}, {goes_with(cell)}"

    def _figure(self) -> Json:
        cell = self._cells.chosen
        if cell is None:
            return {}
        points = parsed(cell["points"])
        trend = points["trend"]["x"], points["trend"]["mean"]
        return cell_plot(cell, apart(points), trend, self._filmed())

    def _choice(self) -> None:
        """Offer the places that have cells; a tick where nothing errs."""
        with ui.element("div").classes("beside").props('role=group aria-label="place"'):
            for name, most in self._cells.places.items():
                fine = "" if most["p_familywise"] < SURE else " ✓"
                choice = button(
                    f"{name.capitalize()}{fine}",
                    lambda name=name: self.look_at(name),
                    look="line tab",
                    testid=f"place-{PLACES[name]}",
                )
                choice.props(f"aria-pressed={str(name == self._cells.place).lower()}")

    def _offer(self, cells: Sequence[Json], chosen: Json) -> None:
        """Offer the cells of one place: as a map, and as a list where the screen is narrow."""
        at = next(k for k, cell in enumerate(cells) if cell is chosen)
        with ui.element("div").classes("stack wide-only"):
            place_map(cells, at, lambda place: self._choose(cells[place]))
            ui.label(
                "Number: how surely the error of the row changes with the column, in standard "
                "deviations; a dot: not at all. Click one, or use the arrow keys."
            ).classes("note")
        self._listed()

    @ui.refreshable_method
    def _listed(self) -> None:
        listed = self._cells.here[:CELLS]
        at = next((k for k, cell in enumerate(listed) if cell is self._cells.chosen), None)
        with ui.element("div").classes("stack narrow-only"):
            ui.label("What the error goes with, and how surely").classes("strong")
            most = max(own["deviation"] for own in listed)
            bars([_bar(own, most) for own in listed], lambda k: self._choose(listed[k]), at)

    def _choose(self, cell: Json) -> None:
        """Draw a cell over the one before: the map has marked it, and keeps the focus."""
        self._cells.chosen = cell
        self._told.refresh()
        self._named.set_text(self._name())
        redraw(self._plot, self._figure())
        self._listed.refresh()

    def _on_point(self, event: events.GenericEventArguments) -> None:
        points = event.args.get("points") if isinstance(event.args, dict) else None
        shot = points[0].get("customdata") if points else None
        if shot is not None:
            self._to_film(int(shot))


def _bar(cell: Json, most: float) -> Bar:
    return Bar(
        f"{channel(cell['channel'])}, {goes_with(cell)}",
        cell["deviation"] / max(most, 1e-9),
        f"{cell['deviation']:.0f}",
        fails=cell["p_familywise"] < SURE,
    )
