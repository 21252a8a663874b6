"""The map of step 2: what is measured, row by row, against what its error may go with.

One cell is chosen and has the focus; arrows move it, and a click or Enter shows its points.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape

from nicegui import events, ui

from analysis.model.structure.findings import ALWAYS
from rigctl.documents import Json
from rigctl.page.model.story.words import channel, goes_with, heading

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
    """Place the map; `choose` is called with the place of the cell that was clicked."""
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
    lines = []
    for row in grid.rows:
        found = "".join(
            f"<td{_look(('first', column in first))}>"
            f"{_cell(cells, grid.places.get((row, column)), chosen, most)}</td>"
            for column in columns
        )
        look = _look(("here", row == at[0]))
        lines.append(f'<tr><th scope="row"{look}>{escape(channel(row))}</th>{found}</tr>')
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
    name = f"{channel(cell['channel'])}, {goes_with(cell)}: {deviation:.1f} standard deviations"
    here = place == chosen
    return (
        f'<button type="button" class="{look}" data-cell="{place}" title="{escape(name)}" '
        f'aria-label="{escape(name)}" aria-pressed="{str(here).lower()}" '
        f'tabindex="{0 if here else -1}">{said}</button>'
    )


def _look(*words: tuple[str, bool]) -> str:
    found = " ".join(word for word, holds in words if holds)
    return f' class="{found}"' if found else ""
