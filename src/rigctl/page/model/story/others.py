"""The effects beside the one that is looked at: its look-alikes, and those that lower most."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from nicegui import ui

from analysis.model.verdict.standing import AT_THE_FLOOR
from rigctl.documents import Json
from rigctl.page.model.story.cards import card_of
from rigctl.page.model.story.errors import Unseen, falls_to
from rigctl.page.model.story.lead import drawing
from rigctl.page.model.story.words import looked_at
from rigctl.page.parts.widgets import button

SHOWN = 4


def others(
    known: Mapping[str, Json],
    found: Json,
    seen: Sequence[Json],
    effect: str,
    look: Callable[[str], None],
) -> None:
    """Place cards of an effect's look-alikes in one bracket, and of a few others.

    Parameters
    ----------
    known
        Documents of all effects, by name.
    seen
        Candidates of the answer `found` that these shots show, the best first.
    look
        Has another effect looked at, by its name.
    """
    like: list[str] = next((c["like"] for c in seen if c["effect"] == effect), [])
    alike = [c for c in seen if c["effect"] in like]
    rest = [c for c in seen if c not in alike and c["effect"] != effect][:SHOWN]
    if alike:
        with ui.element("div").classes("bracket").props("data-testid=look-alikes"):
            ui.label("Look-alikes: they do the same to these shots.").classes("strong")
            ui.label(
                "They bend the points in almost the same way. What tells each apart stands below "
                "it."
            ).classes("note")
            _cards(known, alike, found, look)
    ui.label("Also looked at").classes("strong")
    ui.label(looked_at(found, len(seen), len(known))).classes("note")
    _cards(known, rest, found, look)


def _cards(
    known: Mapping[str, Json],
    candidates: Sequence[Json],
    found: Json,
    look: Callable[[str], None],
) -> None:
    with ui.element("div").classes("cards"):
        for candidate in candidates:
            card = card_of(known[candidate["effect"]])
            with ui.element("div").classes("card"):
                drawing(card)
                ui.label(card.title).classes("strong")
                ui.label(card.notice).classes("note")
                _promise(found, candidate)
                placed = button(
                    "Look at it",
                    lambda name=card.effect: look(name),
                    testid=f"try-{card.effect}",
                )
                placed.props(f'aria-label="Look at {card.title}"')


def _promise(found: Json, candidate: Json) -> None:
    """Say how far the error would fall; nothing where its floor is not known."""
    error, falls = Unseen.of(found), falls_to(found, candidate)
    if error.floor is None:
        return
    if error.value <= AT_THE_FLOOR or falls.number() == error.number():
        ui.label("the error would hardly change").classes("note")
        return
    share = 1.0 - (falls.value - 1.0) / max(error.value - 1.0, 1e-9)
    with ui.element("div").classes("track").props("aria-hidden=true"):
        bar = ui.element("div").classes("bar")
        bar.style(f"width: {100 * max(0.0, min(1.0, share)):.0f}%")
    ui.label(f"error would fall to about {falls.said()}").classes("note")
