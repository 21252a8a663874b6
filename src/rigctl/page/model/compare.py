"""Step 1: what the model predicts against what was measured, quantity by quantity."""

from __future__ import annotations

import json

from nicegui import ui

from rigctl.documents import Json
from rigctl.page.model.effect_words import described
from rigctl.page.parts.quantities import CHANCE, CHI2, ERROR, EXPECTED, PARAMETERS, VALUE
from rigctl.page.parts.tables import Cell, Line, chance, facts, with_error
from rigctl.page.parts.widgets import save_csv

ALARM = 0.01
FAR = 3.0
SHOWN = 8
"""So many that disagree stand on the page at once, the least likely ones."""
PARAMETER = Cell("parameter", "What the fit is free to choose, from all shots together.")


def compare(found: Json) -> None:
    """Place the table of agreement and that of the parameters."""
    with ui.element("div").classes("panel").props("data-testid=compare"):
        with ui.element("div").classes("title"):
            ui.label("1").classes("step")
            ui.label("Compare")
            ui.label(
                f"error now {found['prediction_error']:.3f}, floor 1.000 of the noise"
            ).classes("aside").tooltip(ERROR).props("data-testid=error-now")
            ui.space()
            save_csv(f"{found['campaign']}-agreement", lambda: _rows(found))
        headings: list[Cell | str] = [
            Cell("quantity", "What was measured and predicted; point at a line for its numbers."),
            Cell("χ²/dof", CHI2),
            Cell("error/noise", ERROR),
            Cell("error", "Root mean square error of the prediction in the quantity's unit."),
            "",
            Cell("p", CHANCE),
        ]
        fails = [row for stage in found["stages"] for row in stage["quantities"] if _fails(row)]
        count = sum(len(stage["quantities"]) for stage in found["stages"])
        if fails:
            worst = sorted(row["p_familywise"] for row in fails)[:SHOWN][-1]
            least = [row for row in fails if row["p_familywise"] <= worst]
            shown = sorted(least, key=lambda row: -row["error"])[:SHOWN]
            facts(headings, [_line(row) for row in shown], "agreement")
        few = "" if len(fails) <= SHOWN else f" Of the others the {SHOWN} least likely stand above."
        ui.label(f"{count - len(fails)} of {count} quantities agree within the noise.{few}")
        with ui.expansion("All quantities").props("dense").classes("wide"):
            facts(headings, quantity_lines(found), "all-quantities")
        facts([PARAMETER, Cell("value ± σ", VALUE), ""], _parameters(found), "parameters")


def quantity_lines(found: Json) -> list[Line]:
    """Return the lines of all quantities, stage by stage."""
    lines: list[Line] = []
    for stage in found["stages"]:
        lines.append(Line([Cell(stage["stage"], look="left")], "stage"))
        lines += [_line(row) for row in stage["quantities"]]
    return lines


def _line(row: Json) -> Line:
    fails = _fails(row)
    hover = (
        f"{row['count']} numbers; the floor set by the noise is {row['floor']:.3g} {row['unit']}"
    )
    freedom = row["degrees_of_freedom"]
    return Line(
        [
            Cell(("▲ " if fails else "") + row["quantity"], hover),
            # What nobody sees, as the depth in one view, has no freedom, and no chi-squared.
            f"{row['chi2'] / freedom:.2f}" if freedom > 0 else "",
            f"{row['error']:.2f}",
            f"{row['size']:.3g}",
            Cell(row["unit"], look="left dim"),
            chance(row["p_familywise"]),
        ],
        "fails" if fails else "",
    )


def _fails(row: Json) -> bool:
    return bool(row["p_familywise"] < ALARM)


def _parameters(found: Json) -> list[Line]:
    lines, effects = [], described(found)
    for name, value in found["parameters"].items():
        unit = "" if value["unit"] == "1" else value["unit"]
        words, meaning, expected = _about(name, effects)
        number: Cell | str = with_error(value)
        unexpected = is_unexpected(value, expected)
        if unexpected:
            low, high = expected or (0.0, 0.0)
            said = f"Outside the expected range, {low:g} to {high:g} {unit}".rstrip()
            number = Cell(f"▲ {number}", f"{said}: something that is missing may hide in it.")
        cells = [Cell(words, meaning), number, Cell(unit, look="left dim")]
        lines.append(Line(cells, "fails" if unexpected else ""))
    return lines


def is_unexpected(value: Json, expected: tuple[float, float] | None) -> bool:
    """Say whether a parameter lies outside its expected range by more than its error explains."""
    if expected is None or value["value"] is None:
        return False
    room = FAR * (value.get("sigma") or 0.0)
    return not expected[0] - room <= value["value"] <= expected[1] + room


def _about(name: str, effects: dict[str, Json]) -> tuple[str, str, tuple[float, float] | None]:
    """Return a parameter in words, what it means, and its expected range."""
    if name in PARAMETERS:
        about = PARAMETERS[name]
        return f"{about.name}, {about.meaning.rstrip('.')}", about.meaning, EXPECTED[name]
    effect, _, symbol = name.rpartition(".")
    parameters = effects[effect]["parameters"] if effect in effects else []
    found = next((p for p in parameters if p["symbol"] == symbol), None)
    return (name, "", None) if found is None else (name, found["meaning"], found["plausible"])


def _rows(found: Json) -> list[list[object]]:
    names = ["quantity", "unit", "count", "chi2", "degrees_of_freedom", "error", "size", "floor"]
    rows: list[list[object]] = [["stage", *names, "p_familywise"]]
    rows += [
        [stage["stage"], *(row[name] for name in names), row["p_familywise"]]
        for stage in found["stages"]
        for row in stage["quantities"]
    ]
    return rows


def parsed(points: str) -> Json:
    """Return the points of a cell, which travel as a text of JSON."""
    document: Json = json.loads(points)
    return document
