"""The truth of a challenge beside the answer that was given, each effect with its card."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from nicegui import ui

from rigctl import challenge
from rigctl.game import Clue
from rigctl.model.known_effects import ALL_EFFECTS, effect_document
from rigctl.page.model.story.cards import Card, card_of
from rigctl.page.model.story.lead import drawing
from rigctl.page.parts.tables import minus, with_error

Json = Mapping[str, Any]
OUTCOMES = {
    "right": "Right.",
    "alias": "As good as right: these shots cannot tell your answer from the truth.",
    "partly": "Partly right.",
    "wrong": "Wrong.",
}
NOTHING = {"none": "Nothing", "unexplained": "Something that is in no catalogue"}


def in_titles(names: Sequence[str]) -> str:
    """Return the names of an answer in words."""
    known = cards()
    titles = {name: f"“{card.title}”" for name, card in known.items()} | NOTHING
    return " and ".join(titles.get(name, name) for name in names)


def cards() -> dict[str, Card]:
    """Return the cards of the effects of the catalogue by their names."""
    return {effect.name: card_of(effect_document(effect)) for effect in ALL_EFFECTS}


def clues() -> dict[str, Clue]:
    """Return what hints take from the cards."""
    return {name: Clue(card.where, card.notice) for name, card in cards().items()}


def reveal_beside(
    label: challenge.Label,
    answer: Sequence[str],
    outcome: challenge.Outcome,
    fitted: Mapping[str, Json],
) -> None:
    """Place the outcome, and side by side what was hidden and what was answered.

    Parameters
    ----------
    fitted
        Parameters of the fit by `effect.symbol`, in the catalogue's order.
    """
    look = "good" if outcome in {"right", "alias"} else "bad"
    with ui.element("div").classes(f"verdict {look}").props("data-testid=truth"):
        ui.label(OUTCOMES[outcome]).classes("lead")
        ui.label(f"The truth is: {in_titles(label.answer)}.")
    known = cards()
    with ui.element("div").classes("columns half").props("data-testid=side-by-side"):
        with _side("What was hidden"):
            for one in label.effects:
                unit = "" if one.unit == "1" else f" {one.unit}"
                size = minus(f"Size: {one.amplitude:.4g}{unit} ({one.meaning}).")
                _entry(known.get(one.effect), one.effect, size)
            if not label.effects:
                _entry(None, NOTHING["none"], "")
        with _side("Your answer"):
            for name in answer:
                _entry(known.get(name), NOTHING.get(name, name), _found(name, label, fitted))
    ui.label("The label is the one that was sealed when the campaign was made.").classes("note")


def _side(title: str) -> ui.element:
    side = ui.element("section").classes("panel")
    with side:
        ui.html(escape(title), sanitize=False, tag="h3").classes("card-heading")
    return side


def _entry(card: Card | None, name: str, size: str) -> None:
    with ui.element("div").classes("revealed"):
        if card is not None:
            drawing(card)
        with ui.element("div").classes("stack"):
            ui.label(name if card is None else card.title).classes("strong")
            if card is not None:
                ui.label(card.what).classes("note")
            if size:
                ui.label(size)


def _found(name: str, label: challenge.Label, fitted: Mapping[str, Json]) -> str:
    """Return the fitted size of an answered effect, and how far from the truth it is."""
    hidden = next((one for one in label.effects if one.effect == name), None)
    found = next((fitted[key] for key in fitted if key.startswith(f"{name}.")), None)
    if found is None:
        return "" if name in NOTHING else "Not in the model that is fitted: no size."
    if hidden is None:
        return f"Fitted size: {with_error(found)}."
    size, apart = beside_truth(hidden, fitted)
    return f"Fitted size: {size}, {apart} from the truth." if apart else f"Fitted size: {size}."


def beside_truth(
    hidden: challenge.HiddenEffect, fitted: Mapping[str, Mapping[str, Any]]
) -> tuple[str, str]:
    """Return the fitted size of a hidden effect, and by how many standard errors it is off.

    Parameters
    ----------
    fitted
        Parameters of the fit by `effect.symbol`, in the catalogue's order.
    """
    first = next((fitted[name] for name in fitted if name.startswith(f"{hidden.effect}.")), None)
    if first is None:
        return "not added", ""
    sigma = first.get("sigma")
    if first["value"] is None or not sigma:
        return with_error(first), ""
    return with_error(first), f"{abs(first['value'] - hidden.amplitude) / sigma:.1f} σ"
