"""Cards of the effects: name, two sentences, formula and drawing, in plain words."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from fastapi import FastAPI
from nicegui import ui
from starlette.staticfiles import StaticFiles

from rigctl.documents import Json

HERE = Path(__file__).parent
DRAWINGS = "/drawings"
NAME = re.compile(r"[a-z]+(?:-[a-z]+)*")


@dataclass(frozen=True, slots=True)
class Card:
    """The content of a card.

    Attributes
    ----------
    where
        Where it acts, such as `at the bounce`.
    what, notice
        The mechanism, and how one notices it.
    formula
        MathML; of an effect of the user's own its plain formula, escaped by whoever shows it.
    drawing
        Address of the drawing and its text alternative; empty where there is none.
    """

    effect: str
    title: str
    where: str
    what: str
    notice: str
    formula: str
    typeset: bool
    drawing: tuple[str, str] = ("", "")


def drawings_route(app: FastAPI) -> None:
    """Register the drawings, which browsers fetch as pictures."""
    app.mount(DRAWINGS, StaticFiles(directory=HERE / "drawings"))


def slider_script() -> None:
    """Have the page move previews by itself."""
    ui.add_head_html(f"<script>{(HERE / 'slider.js').read_text('utf-8')}</script>")


def card_of(effect: Json) -> Card:
    """Return the card of an effect by its document; one of the user's own brings its own text."""
    name = str(effect["effect"])
    said = _cards().get(name)
    if said is None:
        return Card(
            effect=name,
            title=effect["title"],
            where=effect["stage"],
            what=f"{effect['parameters'][0]['meaning']}.",
            notice=effect["gives_away"],
            formula=effect["formula"],
            typeset=False,
        )
    drawing = (f"{DRAWINGS}/{name}.svg", said["drawing"])
    return Card(
        effect=name,
        title=said["title"],
        where=said["where"],
        what=said["what"],
        notice=said["notice"],
        formula=said["formula"],
        typeset=True,
        drawing=drawing,
    )


def in_plain(text: str) -> str:
    """Return a text with the names of effects in plain words, in quotation marks."""

    def plain(found: re.Match[str]) -> str:
        said = _cards().get(found[0])
        return found[0] if said is None else f"“{said['title']}”"

    return NAME.sub(plain, text)


def titled(name: str) -> str:
    """Return an effect's title; another name as it is."""
    said = _cards().get(name)
    return name if said is None else said["title"]


def named(name: str) -> str:
    """Return an effect's title with its name in brackets; another name as it is."""
    said = _cards().get(name)
    return name if said is None else f"{said['title']} ({name})"


@cache
def _cards() -> dict[str, dict[str, str]]:
    cards: dict[str, dict[str, str]] = json.loads((HERE / "cards.json").read_text("utf-8"))
    return cards
