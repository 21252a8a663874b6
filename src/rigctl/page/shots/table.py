"""Tables of shots: filtered by words and numbers, sorted by any column, opened by a click."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from nicegui import ui

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.parts.quantities import COEFFICIENTS, SETTINGS
from rigctl.page.parts.readings import Impact
from rigctl.page.parts.tables import lowered
from rigctl.store import ShotRecord

Row = Mapping[str, object]
Test = Callable[[Row], bool]
COMPARED: dict[str, Callable[[Any, Any], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "=": operator.eq,
}
CLAUSE = re.compile(
    r"\s*(?P<column>[^<>=!]*?)\s*(?P<sign><=|>=|!=|<|>|=)\s*(?P<value>[^<>=!]+?)\s*"
)
HINT = "a word, or offset > 10, e < 0.7"


class FilterError(ValueError):
    """What was typed compares something that cannot be compared; the message names it."""


@dataclass(frozen=True, slots=True)
class Filter:
    """The clauses of a filter, of which a row must pass all."""

    tests: tuple[Test, ...]

    @classmethod
    def of(cls, text: str, columns: Mapping[str, str]) -> Filter:
        """Return what a text asks for; its clauses are apart by commas or by `and`.

        Parameters
        ----------
        columns
            Label of each column by the key under which rows hold it. A clause may name either, or
            a beginning that only one has; units may be left out.

        Raises
        ------
        FilterError
            No column has that name, or several have, or a number is missing.
        """
        clauses = (part for part in re.split(r",|\band\b", text.lower()) if part.strip())
        return cls(tuple(_test(clause, columns) for clause in clauses))

    def keeps(self, row: Row) -> bool:
        """Say whether a row passes."""
        return all(test(row) for test in self.tests)


def _test(clause: str, columns: Mapping[str, str]) -> Test:
    found = CLAUSE.fullmatch(clause)
    if found is None:
        if re.search("[<>=]", clause):
            raise FilterError(f"“{clause.strip()}” compares nothing; write {HINT}")
        word = clause.strip()
        return lambda row: any(word in str(row.get(key, "")).lower() for key in columns)
    key = _column(found["column"], columns)
    compare = COMPARED[found["sign"]]
    try:
        limit = float(found["value"].replace("−", "-"))
    except ValueError:
        return _of_words(key, found["sign"], found["value"])

    def test(row: Row) -> bool:
        value = row.get(key)
        return isinstance(value, (int, float)) and compare(value, limit)

    return test


def _of_words(key: str, sign: str, value: str) -> Test:
    if sign not in {"=", "!="}:
        raise FilterError(f"“{value}” is no number; write {HINT}")
    return lambda row: (str(row.get(key, "")).lower() == value) == (sign == "=")


def _column(name: str, columns: Mapping[str, str]) -> str:
    wanted = _plain(name)
    names = {key: {_plain(key), _plain(label.partition(",")[0])} for key, label in columns.items()}
    exact = [key for key, own in names.items() if wanted in own]
    begun = exact or [k for k, own in names.items() if any(n.startswith(wanted) for n in own)]
    if len(begun) == 1 and wanted:
        return begun[0]
    said = "names several columns" if begun and wanted else "names no column"
    listed: Sequence[str] = [columns[key].partition(",")[0] for key in (begun or columns)]
    raise FilterError(f"“{name.strip()}” {said}: {', '.join(listed)}")


def _plain(name: str) -> str:
    return re.sub(r"[\s_]+", " ", name.lower().replace("\u00a0", " ")).strip()


MOST_LISTED = 2000
"""Earlier shots are found by REST, or by their campaign."""
Column = dict[str, Any]


def column(name: str, label: str, align: str = "right", **more: object) -> Column:
    """Return a sortable column of a table whose rows hold it under `name`."""
    return {"name": name, "label": label, "field": name, "sortable": True, "align": align, **more}


SORTED = """!props.col.__thClass.includes("sorted") ? "none"
  : props.col.__thClass.includes("sort-desc") ? "descending" : "ascending"
"""
"""How the rows are sorted by a column, as assistive technology names it."""
ROOMY: dict[str, Any] = {"classes": "roomy", "headerClasses": "roomy"}
"""Of a column that a telephone has no room for."""
SIGNED: dict[str, Any] = {":format": "value => String(value ?? '').replace('-', '−')"}
PLACES: dict[str, Any] = {
    ":format": "value => typeof value === 'number' ? value.toFixed(4).replace('-', '−') : value"
}
"""Of coefficients, so that their digits stand below each other."""
WHY: dict[str, Any] = {"style": "white-space: normal; min-width: 190px; line-height: 1.3"}
FIRED = [
    column("number", "shot"),
    column("state", "state", "left"),
    column("pressure_a", "pressure a, kPa"),
    column("pressure_b", "pressure b, kPa", **ROOMY),
    column("offset", "offset, mm"),
]
COLUMNS = [
    *FIRED[:2],
    column("campaign", "campaign", "left"),
    *FIRED[2:],
    column("at", "accepted", "left", **ROOMY),
    column("failure", "why not", "left", **WHY),
    column("tags", "tags", "left"),
]
MEASURED_COLUMNS = [
    *FIRED,
    column("v_n", "v_n, m/s", **SIGNED, **ROOMY),
    column("v_s", "v_s, m/s", **SIGNED, **ROOMY),
    column("e", "e", **PLACES),
    column("e_sigma", "±\u00a0of\u00a0e", **PLACES, **ROOMY),
    column("beta", "β", **PLACES),
    column("beta_sigma", "±\u00a0of\u00a0β", **PLACES, **ROOMY),
    column("failure", "why not", "left", **WHY),
    column("tags", "tags", "left"),
]


HEADINGS = {
    **{name: about.meaning for name, about in COEFFICIENTS.items()},
    "v_n": "Approach along the line of centres, with the sign that files have: negative while the "
    "spheres approach.",
    "pressure_a": SETTINGS["pressure_a_kpa"].meaning,
    "pressure_b": SETTINGS["pressure_b_kpa"].meaning,
    "pressure": SETTINGS["pressure_a_kpa"].meaning,
    "offset": SETTINGS["offset_mm"].meaning,
    "e_sigma": "Standard error of e.",
    "beta_sigma": "Standard error of β; large where the surfaces hardly slide.",
    "number": "Counts all shots of this store.",
    "shot": "Number of the shot that the step fired; shots are counted through the store.",
    "state": "Where the shot stands: analysed means measured, refused means it could not be.",
    "campaign": "Shots of one campaign are fitted together.",
    "at": "When the rig accepted it, time of the daemon's host.",
    "failure": "Why it did not come through, could not be measured, or does not count.",
    "tags": "Words that a person gave it, to filter by.",
    "why": "Why it did not come through, or could not be measured.",
    "step": "Its place in the order of firing.",
    "fate": "Whether it waits, is under way, was measured, or was not.",
}


def latest(desk: Desk, campaign: str | None) -> list[ShotRecord]:
    """Return the latest shots, of one campaign or of all, the last first; blocks for the disk."""
    return desk.daemon.store.catalogue.latest(MOST_LISTED, campaign)


class ShotTable:
    """A table of shots, placed where it is made; filter, order and page stay when it grows.

    Parameters
    ----------
    measured
        Whether it shows coefficients, or else campaign and time.
    """

    def __init__(self, *, measured: bool) -> None:
        self._empty = ui.label("Reading …").classes("empty")
        self._whole = ui.element("div").classes("wide")
        with self._whole:
            columns = MEASURED_COLUMNS if measured else COLUMNS
            self._labels = {own["name"]: str(own["label"]) for own in columns}
            self._given = ui.input(placeholder=f"Filter: {HINT}", validation=self._fault)
            self._given.classes("filter").on_value_change(self._choose)
            self._given.props(
                'outlined dense clearable hide-bottom-space data-testid=filter aria-label="Filter"'
            )
            self._table = ui.table(rows=[], columns=columns, pagination=20, row_key="number")
        self._table.props("dense flat data-testid=shots").classes("wide")
        link_cells(self._table, "number", "/shots/", "id")
        self._table.on("rowClick", lambda event: ui.navigate.to(f"/shots/{event.args[1]['id']}"))
        explain_headings(self._table)
        self._whole.set_visibility(False)
        self._rows: list[dict[str, object]] = []

    def show(self, shots: Sequence[ShotRecord], impacts: Sequence[Impact] = ()) -> None:
        """Show these shots, and what those of them were measured to be."""
        known = {impact.number: impact for impact in impacts}
        self._rows = [{**_row(shot), **_measured(known.get(shot.number))} for shot in shots]
        self._choose()
        self._whole.set_visibility(bool(shots))
        self._empty.set_visibility(not shots)
        self._empty.set_text("No shot has been fired yet: arm and fire one on the page Rig.")

    def _choose(self) -> None:
        """Show the rows that the filter keeps; one that cannot be read keeps all."""
        try:
            kept = Filter.of(self._given.value or "", self._labels)
        except FilterError:
            kept = Filter(())
        self._table.rows = [row for row in self._rows if kept.keeps(row)]

    def _fault(self, given: str | None) -> str | None:
        try:
            Filter.of(given or "", self._labels)
        except FilterError as error:
            return str(error)
        return None


def link_cells(table: ui.table, column_name: str, place: str, key: str) -> None:
    """Make a column's cells links to `place` and what rows hold under `key`: for the keyboard."""
    with table.add_slot(f"body-cell-{column_name}"), ui.element("q-td").props(":props=props"):
        link = ui.element("a").on("click", js_handler="(event) => event.stopPropagation()")
        link.props[":href"] = f"props.row.{key} ? '{place}' + props.row.{key} : undefined"
        link.props[":textContent"] = "props.value"


def explain_headings(table: ui.table, meanings: Mapping[str, str] = HEADINGS) -> None:
    """Let headings say what their columns hold on hover, and sort by the keys as by a click.

    They are elements, as links are: a slot with a template would be made anew with each news of a
    page, and lose the focus.
    """
    for own in table.columns:
        words = lowered(escape(str(own["label"])))
        with table.add_slot(f"header-cell-{own['name']}"):
            heading = ui.element("th")
        heading.props[":class"] = "props.col.__thClass"
        heading.props[":style"] = "props.col.headerStyle"
        if meaning := meanings.get(own["name"]):
            heading.props["title"] = meaning
        with heading:
            if own["align"] == "left":
                ui.html(words, sanitize=False, tag="span")
            if own.get("sortable"):
                arrow = ui.element("q-icon").props("name=arrow_upward")
                arrow.props[":class"] = "props.col.__iconClass"
                heading.props["tabindex"] = 0
                heading.props[":aria-sort"] = SORTED
                for event in ("click", "keydown.enter", "keydown.space.prevent"):
                    heading.on(event, js_handler="() => props.sort(props.col)")
            if own["align"] != "left":
                ui.html(words, sanitize=False, tag="span")


def _row(shot: ShotRecord) -> dict[str, object]:
    asked = shot.settings
    return {
        "id": shot.id,
        "number": shot.number,
        "state": str(shot.state).replace("_", " "),
        "campaign": shot.campaign or "",
        "pressure_a": None if asked is None else round(asked.pressure_a_kpa, 2),
        "pressure_b": None if asked is None else round(asked.pressure_b_kpa, 2),
        "offset": None if asked is None else round(asked.offset_mm, 3),
        "at": f"{shot.accepted_at.astimezone():%Y-%m-%d %H:%M:%S}",
        "failure": f"excluded: {shot.excluded}" if shot.excluded else shot.failure or "",
        "tags": ", ".join(shot.tags),
    }


def _measured(impact: Impact | None) -> dict[str, object]:
    """Return the cells of a measured shot, with the places that the table has room for."""
    if impact is None:
        return {}
    cells: dict[str, object] = {}
    for name, told in (("v_n", impact.v_n), ("v_s", impact.v_s)):
        cells[name] = "" if told is None else round(told[0], 3)
    for name, told in (("e", impact.e), ("beta", impact.beta)):
        cells[name] = "" if told is None else round(told[0], 4)
        cells[f"{name}_sigma"] = "" if told is None else round(told[1], 4)
    return cells


def stored(desk: Desk, shot: str) -> ShotRecord | None:
    """Return a shot, or place the reason why there is none."""
    try:
        return desk.daemon.store.shot(shot)
    except RigError as error:
        ui.label(error.sentence()).classes("verdict bad")
        ui.link("All shots", "/shots")
        return None
