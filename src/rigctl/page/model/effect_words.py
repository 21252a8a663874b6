"""Descriptions of effects: those of the catalogue, and the user's own of an answer."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from rigctl.documents import Json
from rigctl.model.known_effects import ALL_EFFECTS, effect_document
from rigctl.page.parts.widgets import button

_CATALOGUE: dict[str, Json] = {effect.name: effect_document(effect) for effect in ALL_EFFECTS}


def described(found: Json) -> dict[str, Json]:
    """Return all effects that an answer of the model names, by their names.

    One of the user's own has its `file` besides.
    """
    return _CATALOGUE | {own["effect"]: own for own in found["own"]}


def in_unit(parameter: Json, before: str = " ") -> str:
    """Return the unit of a parameter to stand behind a number; nothing for a pure number."""
    return "" if parameter["unit"] == "1" else f"{before}{parameter['unit']}"


def explain(effect: Json) -> None:
    """Open formula, parameters, source and file of an effect."""
    with ui.dialog(value=True) as dialog, ui.card().classes("ask").props("data-testid=effect"):
        with ui.element("div").classes("title"):
            ui.label(effect["title"])
            ui.label(f"{effect['effect']}, acts in: {effect['stage']}").classes("aside")
        ui.label(effect["formula"]).classes("formula")
        for parameter in effect["parameters"]:
            ui.label(f"{parameter['symbol']}{in_unit(parameter, ', ')}: {parameter['meaning']}")
        ui.label(f"How to notice it: {effect['gives_away']}")
        if effect["confused_with"]:
            ui.label(f"Easily confused with: {', '.join(effect['confused_with'])}")
        ui.label(f"Source: {effect['source']}").classes("note")
        if "file" in effect:
            ui.label(f"An effect of your own, from {effect['file']}").classes("note")
        with ui.element("div").classes("beside ends"):
            button("Close", dialog.close)
    dialog.on("hide", dialog.delete)


def left_out(found: Json) -> None:
    """Name every file of the user's that is of no use, with its line and what to do."""
    for fault in found["faults"]:
        place = f"{Path(fault['path']).name}, line {fault['line']}"
        told = ui.label(f"Left out: {fault['effect']} ({place}) {fault['what']}; {fault['todo']}.")
        told.classes("note warn").props("data-testid=fault").tooltip(fault["path"])
