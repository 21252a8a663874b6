"""Bars of the story: a name, its length, and what is said beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from nicegui import ui

from rigctl.page.parts.widgets import button

LEAST_SHARE = 0.01


@dataclass(frozen=True, slots=True)
class Bar:
    """A name, a share of the longest, what is said beside it, and whether it fails.

    `beside` is said besides, more quietly.
    """

    name: str
    share: float
    said: str
    fails: bool
    beside: str = ""


def bars(rows: Sequence[Bar], choose: Callable[[int], None] | None = None) -> list[ui.element]:
    """Place bars below each other, and return their names.

    With `choose` these are buttons, which give their place.
    """
    names: list[ui.element] = []
    with ui.element("div").classes("bars"):
        for place, row in enumerate(rows):
            name = f"▲ {row.name}" if row.fails else row.name
            if choose is None:
                placed: ui.element = ui.label(name)
            else:
                placed = button(
                    name, lambda place=place: choose(place), look="choice", testid=f"cell-{place}"
                )
                placed.props("align=left")
            names.append(placed)
            placed.classes("fails" if row.fails else "")
            bar = ui.element("div").classes("bar fails" if row.fails else "bar fine")
            bar.style(f"width: {100 * max(LEAST_SHARE, row.share):.0f}%").props("aria-hidden=true")
            with ui.element("div").classes("said-beside"):
                ui.label(row.said).classes("strong")
                if row.beside:
                    ui.label(row.beside).classes("note")
    return names
