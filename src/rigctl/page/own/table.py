"""A table that was brought: what each column is and in which unit, rows left out, the campaign."""

from __future__ import annotations

import shutil
from pathlib import Path

from nicegui import events, ui

from rigctl.errors import RigError
from rigctl.measuring.own_table import (
    MEANINGS,
    UNITS,
    Column,
    Converted,
    convert,
    read_table,
    unit_in,
    write_table,
)
from rigctl.page.desk import Desk
from rigctl.page.own.brought import CAMPAIGN, MEASURED, Brought
from rigctl.page.own.measured import onwards, save_campaign
from rigctl.page.parts.fields import OptionalNumber
from rigctl.page.parts.tables import minus

PREVIEWED = 6
NAMED = 8
"""So many rows that are left out are named; of the others their number."""
BODIES = {False: "two equal balls", True: "a ball and a fixed surface"}
DIAMETER_MM, DIAMETERS_MM = 25.4, (0.1, 1000.0)


class TableView:
    """A preview with two select boxes a column; below it what the rows say so."""

    def __init__(self, desk: Desk, brought: Brought, path: Path) -> None:
        self._desk, self._brought, self._path = desk, brought, path
        try:
            self._table = read_table(path)
        except RigError as error:
            said = ui.label(error.sentence()).classes("verdict bad")
            said.props("data-testid=own-failed role=alert")
            ui.link("bring something else", "/own").classes("note")
            return
        self._columns = self._table.guessed()
        self._plate, self._diameter_mm = False, DIAMETER_MM
        with ui.element("section").classes("panel"):
            heading = "1 Say what its columns are"
            ui.html(heading, sanitize=False, tag="h3").classes("card-heading")
            ui.label(
                f"{path.name}: {len(self._table.rows)} rows. Choose one column for the speed, or "
                "the height of the fall, before each impact, and one for after it."
            ).props("data-testid=own-table")
            self._preview()
        with ui.element("section").classes("panel"):
            self._bodies()
            self._result()

    def _preview(self) -> None:
        with ui.element("div").classes("mapping"), ui.element("table"):
            with ui.element("thead"):
                with ui.element("tr"):
                    for place in range(len(self._columns)):
                        with ui.element("th").props("scope=col"):
                            self._choice(place)
                with ui.element("tr"):
                    for name in self._table.names:
                        ui.html(_text(name), sanitize=True, tag="th").props("scope=col")
            with ui.element("tbody"):
                for row in self._table.rows[:PREVIEWED]:
                    with ui.element("tr"):
                        for text in row:
                            ui.html(_text(text), sanitize=True, tag="td")
        more = len(self._table.rows) - PREVIEWED
        if more > 0:
            ui.label(f"and {more} rows more").classes("note")

    def _choice(self, place: int) -> None:
        chosen, name = self._columns[place], self._table.names[place]
        words = {meaning: about.words for meaning, about in MEANINGS.items()}

        def mean(event: events.ValueChangeEventArguments[str]) -> None:
            units = list(UNITS[MEANINGS[event.value].kind])
            # Also after another meaning was tried: the unit is that of the column's name.
            likely = unit_in(name)
            now = likely if likely in units else units[0]
            self._columns[place] = Column(event.value, now)
            unit.set_options(units, value=now)
            unit.set_visibility(units != [""])
            self._result.refresh()

        def measure(event: events.ValueChangeEventArguments[str]) -> None:
            self._columns[place] = Column(self._columns[place].meaning, event.value)
            self._result.refresh()

        select = ui.select(words, value=chosen.meaning, on_change=mean)
        select.props(
            f'outlined dense options-dense aria-label="what {name} is" data-testid=means-{place}'
        )
        units = list(UNITS[MEANINGS[chosen.meaning].kind])
        unit = ui.select(units, value=chosen.unit, on_change=measure)
        unit.props(
            f'outlined dense options-dense aria-label="unit of {name}" data-testid=unit-{place}'
        )
        unit.set_visibility(units != [""])

    def _bodies(self) -> None:
        ui.html("2 What met", sanitize=False, tag="h3").classes("card-heading")

        def meet(event: events.ValueChangeEventArguments[bool]) -> None:
            self._plate = bool(event.value)
            self._result.refresh()

        def size() -> None:
            self._diameter_mm = diameter.value or 0.0
            self._result.refresh()

        with ui.element("div").classes("beside"):
            ui.radio(BODIES, value=self._plate, on_change=meet).props("inline dense")
            diameter = OptionalNumber("Diameter, mm", "ball-diameter-mm", DIAMETERS_MM, "mm")
            diameter.field.set_value(DIAMETER_MM)
            diameter.field.on_value_change(size)

    @ui.refreshable_method
    def _result(self) -> None:
        ui.html("3 Your campaign", sanitize=False, tag="h3").classes("card-heading")
        try:
            found = convert(self._table, self._columns)
        except RigError as error:
            ui.label(error.sentence()).classes("note fails").props(
                "data-testid=own-open role=status"
            )
            return
        good, of = len(found.impacts), len(self._table.rows)
        ui.label(f"{good} of {of} rows are impacts.").classes("strong").props(
            "data-testid=own-rows role=status"
        )
        _left_out(found)
        if not found.impacts or not self._diameter_mm:
            return
        first = found.impacts[0].speeds
        ui.label(
            f"First: it met at {-first[0]:.3g} m/s and parted at {first[2]:.3g} m/s, so e is "
            f"{first[2] / -first[0]:.3f}."
        ).classes("note")
        campaign = self._write(found)
        with ui.element("div").classes("beside"):
            onwards(self._desk, campaign, good, "impacts")
            save_campaign(self._brought)
            ui.link("bring something else", "/own").classes("note")

    def _write(self, found: Converted) -> Path:
        folder = self._brought.folder / MEASURED / CAMPAIGN
        shutil.rmtree(folder, ignore_errors=True)
        diameter_m = 1e-3 * self._diameter_mm
        write_table(folder, self._path.stem, found, diameter_m, plate=self._plate)
        return folder


def _left_out(found: Converted) -> None:
    """Name the rows that are left out, each with its line and why."""
    for line, reason in found.left_out[:NAMED]:
        ui.label(minus(f"▲ Line {line} is left out: {reason}.")).classes("note fails")
    if len(found.left_out) > NAMED:
        ui.label(f"and {len(found.left_out) - NAMED} lines more").classes("note")


def _text(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;") or "&nbsp;"
