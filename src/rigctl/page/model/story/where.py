"""Step 2 of the story: what the error goes with; a cell moves the plot, a point moves the film."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape

from nicegui import events, ui

from analysis.model.structure.findings import ALWAYS
from analysis.model.verdict.standing import SURE, Standing
from rigctl.documents import Json
from rigctl.page.model.effect_words import described
from rigctl.page.model.story.bars import Bar, bars
from rigctl.page.model.story.cards import card_of
from rigctl.page.model.story.plots import cell_plot
from rigctl.page.model.story.points import points_of
from rigctl.page.model.story.words import asks, channel, goes_with, heading, where
from rigctl.page.model.where import apart, block_of, undetermined
from rigctl.page.parts.choosing import Choice, press
from rigctl.page.parts.widgets import plot, redraw

GROUPS = (
    ("", (ALWAYS,)),
    ("How it hit", ("ln v_n", "ln v_s/v_n", "spin along v_t x n", "spin about n")),
    ("Where", ("contact X", "contact Y", "contact Z")),
    ("In flight", ("time",)),
    ("In the picture", ("field X", "field Y", "field Z")),
)
SET_UP = "Set-up"
"""Of every column that no group names: settings, the order, and what a lab has recorded besides."""
LEAST = 3.0
"""Standard deviations; below, a cell is a dot."""
STRONG, MIDDLE = 0.5, 0.15
"""Shares of the map's largest number from which a cell is drawn full, or half."""
DARKEST = 20.0
"""That number at least: a map in which nothing errs has no dark cell."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Cells by row and column; `groups` are names with their columns, in the order drawn.

    Attributes
    ----------
    places
        Of each row and column, the place in the list of cells.
    """

    rows: list[str]
    groups: list[tuple[str, list[str]]]
    places: dict[tuple[str, str], int]

    @classmethod
    def of(cls, cells: Sequence[Json]) -> Grid:
        """Order cells: the row first that shows most; physics before settings."""
        present = {str(cell["covariate"]): None for cell in cells}
        groups = [(name, [c for c in columns if c in present]) for name, columns in GROUPS]
        grouped = {column for _, columns in groups for column in columns}
        groups.append((SET_UP, sorted(column for column in present if column not in grouped)))
        return cls(
            list(dict.fromkeys(str(cell["channel"]) for cell in cells)),
            [group for group in groups if group[1]],
            {(str(c["channel"]), str(c["covariate"])): k for k, c in enumerate(cells)},
        )


def place_map(cells: Sequence[Json], chosen: int, choose: Callable[[int], None]) -> None:
    """Place the map; `choose` is called with the place of the cell that was clicked.

    One cell is chosen and has the focus; arrows move it, and a click or Enter shows its points.
    """
    drawn = ui.html(_table(cells, chosen), sanitize=False).classes("map").props("data-testid=map")

    def on_click(event: events.GenericEventArguments) -> None:
        choose(int(event.args))

    drawn.on(
        "click",
        on_click,
        js_handler="(e) => { const cell = window.chooseInMap(e); if (cell) emit(cell); }",
    )
    drawn.on("keydown", js_handler="(event) => window.moveInMap(event)")


def _table(cells: Sequence[Json], chosen: int) -> str:
    grid = Grid.of(cells)
    most = max((cell["deviation"] for cell in cells), default=LEAST)
    at = cells[chosen]["channel"], cells[chosen]["covariate"]
    groups = "".join(_group(name, len(columns)) for name, columns in grid.groups)
    columns = [column for _, columns in grid.groups for column in columns]
    first = {columns[0] for _, columns in grid.groups}
    heads = "".join(
        f'<th scope="col"{_look(("first", c in first), ("here", c == at[1]))}>'
        f"<span>{escape(heading(c))}</span></th>"
        for c in columns
    )
    lines, named = [], {str(cell["channel"]): cell for cell in cells}
    for row in grid.rows:
        found = "".join(
            f"<td{_look(('first', column in first))}>"
            f"{_cell(cells, grid.places.get((row, column)), chosen, most)}</td>"
            for column in columns
        )
        look = _look(("here", row == at[0]))
        lines.append(f'<tr><th scope="row"{look}>{escape(channel(named[row]))}</th>{found}</tr>')
    return (
        '<table><caption class="unseen">How surely the error of each row changes with each '
        "column, in standard deviations; arrows move, Enter shows</caption><thead>"
        f'<tr class="groups"><td></td>{groups}</tr><tr class="heads"><td></td>{heads}</tr>'
        f"</thead><tbody>{''.join(lines)}</tbody></table>"
    )


def _group(name: str, count: int) -> str:
    """Return the head over the columns of a group; one without a name is no head."""
    if not name:
        return f'<td colspan="{count}"></td>'
    return f'<th colspan="{count}" scope="colgroup"><span>{escape(name)}</span></th>'


def _cell(cells: Sequence[Json], place: int | None, chosen: int, most: float) -> str:
    if place is None:
        return ""
    cell = cells[place]
    deviation = cell["deviation"]
    said = f"{deviation:.0f}" if deviation >= LEAST else "·"
    share = deviation / max(most, DARKEST)
    look = "quiet"
    if deviation >= LEAST:
        look = "strong" if share >= STRONG else "middle" if share >= MIDDLE else "weak"
    name = f"{channel(cell)}, {goes_with(cell)}: {deviation:.1f} standard deviations"
    here = place == chosen
    return (
        f'<button type="button" class="{look}" data-cell="{place}" title="{escape(name)}" '
        f'aria-label="{escape(name)}" aria-pressed="{str(here).lower()}" '
        f'tabindex="{0 if here else -1}">{said}</button>'
    )


def _look(*words: tuple[str, bool]) -> str:
    found = " ".join(word for word, holds in words if holds)
    return f' class="{found}"' if found else ""


ASKED = (
    "Dots: what is left of each frame, on top of the change that the frames ask for when place, "
    "speed and moment of contact of each shot may go along with it."
)
CELLS = 6
PLACES = {"at the bounce": "contact", "in the air": "flight", "in the camera": "camera"}
"""Parts of the way in which cells are disturbed, by the words of the effects that act there."""


def cause_first(found: Json, standing: Standing | None) -> list[Json]:
    """Return the findings of a fit, those first that lie where the missing effect acts.

    What a contact lacks bends the flights after it, often more surely than the contact itself shows
    it: named first is where it happens, if it shows there at all.
    """
    findings: list[Json] = list(found["findings"])
    missing = standing.missing if standing is not None else ()
    card = card_of(described(found)[missing[0]]) if missing else None
    place = "" if card is None else PLACES.get(card.where, "")
    here = [cell for cell in findings if block_of(cell) == place and _is_sure(cell)]
    if not here:
        return findings
    first = _tells_most(here)
    return sorted(findings, key=lambda cell: (cell is not first, block_of(cell) != place))


SETTINGS = ("pressure_a_kpa", "pressure_b_kpa", "offset_mm", "delay_us")
"""They bring about how it hits, which is named in their place where it says half as much."""
HALF = 0.5


def _tells_most(cells: Sequence[Json]) -> Json:
    """Return the sure cell that says most: no mean and no setting where a hit says it."""
    best = cells[0]
    if best["covariate"] not in {ALWAYS, *SETTINGS}:
        return best
    least = HALF * best["deviation"]
    courses = [
        cell
        for cell in cells
        if cell["channel"] == best["channel"]
        and cell["covariate"] in GROUPS[1][1]
        and cell["deviation"] >= least
    ]
    return max(courses, key=lambda cell: cell["deviation"], default=best)


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
        self._places: Choice[str] | None = None
        self._names: list[ui.element] = []

    def take(self, cells: Sequence[Json], standing: Standing) -> None:
        """Look at the cells of another answer, the most striking one first."""
        self._cells, self._standing = Cells(cells), standing

    def look_at(self, place: str) -> None:
        """Look at the most striking cell of one of `PLACES`."""
        found = self._cells.look_at(place)
        if found and self._cells.chosen is not None and self._places is not None:
            self._places.press(place)
            self._map.refresh()
            self._listed.refresh()
            self._choose(self._cells.chosen)

    def place(self) -> None:
        """Place sentence, map and plot."""
        if self._cells.chosen is None:
            return
        self._offer()
        self._told()
        with ui.element("div").classes("columns where"):
            with ui.element("div").classes("stack"):
                self._map()
                self._listed()
            with ui.element("div").classes("stack"):
                self._named = ui.label(self._name()).classes("strong")
                self._plot = plot(self._figure())
                self._plot.on("plotly_click", self._on_point).props("data-testid=story-points")
                ui.label("Click a dot: the film above shows its shot, ringed here.").classes("note")
                self._meant = ui.label(ASKED).classes("note")
                self._unsaid = ui.label().classes("note")
                self._say_undetermined()

    @ui.refreshable_method
    def _told(self) -> None:
        if (cell := self._cells.chosen) is not None:
            said = where(cell, points_of(cell), self._standing)
            ui.label(said).classes("lede").props("data-testid=story-where")

    def ring(self) -> None:
        """Ring the shot whose film is shown."""
        if self._cells.chosen is not None:
            redraw(self._plot, self._figure())

    def _name(self) -> str:
        cell = self._cells.chosen
        return "" if cell is None else f"{channel(cell).capitalize()}, {goes_with(cell)}"

    def _say_undetermined(self) -> None:
        cell = self._cells.chosen
        points = None if cell is None else points_of(cell)
        self._meant.set_visibility(points is not None and asks(points))
        said = "" if points is None else undetermined(points)
        self._unsaid.set_text(said)
        self._unsaid.set_visibility(bool(said))

    def _figure(self) -> Json:
        cell = self._cells.chosen
        if cell is None:
            return {}
        points = points_of(cell)
        trend = (points["trend"]["x"], points["trend"]["mean"]) if _is_sure(cell) else ((), ())
        return cell_plot(cell, apart(points), trend, self._filmed())

    def _offer(self) -> None:
        """Offer the places that have cells; a tick where nothing errs."""
        words = {
            name: f"{name.capitalize()}{'' if most['p_familywise'] < SURE else ' ✓'}"
            for name, most in self._cells.places.items()
        }
        testids = {name: f"place-{block}" for name, block in PLACES.items()}
        self._places = Choice("place", words, self._cells.place, self.look_at, testids)

    @ui.refreshable_method
    def _map(self) -> None:
        """Offer the cells of one place as a map; where the screen is narrow it is a list."""
        cells = self._cells.here
        at = next(k for k, cell in enumerate(cells) if cell is self._cells.chosen)
        with ui.element("div").classes("stack wide-only"):
            place_map(cells, at, lambda place: self._choose(cells[place]))
            ui.label(
                "Number: how surely the error of the row changes with the column, in standard "
                "deviations, whatever its size; a dot: not at all. Framed: the cell whose points "
                "are drawn. Click another, or use the arrow keys."
            ).classes("note")

    @ui.refreshable_method
    def _listed(self) -> None:
        listed = self._cells.here[:CELLS]
        with ui.element("div").classes("stack narrow-only"):
            ui.label("What the error goes with, and how surely").classes("strong")
            most = max(own["deviation"] for own in listed)
            rows = [_bar(own, most) for own in listed]
            self._names = bars(rows, lambda k: self._choose(listed[k]))
        self._mark()

    def _mark(self) -> None:
        for cell, name in zip(self._cells.here, self._names, strict=False):
            press(name, pressed=cell is self._cells.chosen)

    def _choose(self, cell: Json) -> None:
        """Draw a cell over the one before: the map has marked it, and keeps the focus."""
        self._cells.chosen = cell
        self._told.refresh()
        self._named.set_text(self._name())
        self._say_undetermined()
        redraw(self._plot, self._figure())
        self._mark()

    def _on_point(self, event: events.GenericEventArguments) -> None:
        points = event.args.get("points") if isinstance(event.args, dict) else None
        shot = points[0].get("customdata") if points else None
        if shot is not None:
            self._to_film(int(shot))


def _is_sure(cell: Json) -> bool:
    """Return whether a line through a cell's points shows more than chance."""
    return bool(cell["p_familywise"] < SURE)


def _bar(cell: Json, most: float) -> Bar:
    return Bar(
        f"{channel(cell)}, {goes_with(cell)}",
        cell["deviation"] / max(most, 1e-9),
        f"{cell['deviation']:.0f}",
        fails=cell["p_familywise"] < SURE,
    )
