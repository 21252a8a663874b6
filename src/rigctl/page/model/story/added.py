"""Step 4 of the story: what adding an effect did, in words and on the axes of before."""

from __future__ import annotations

from nicegui import ui

from analysis.model.verdict.standing import AT_THE_FLOOR
from rigctl.documents import Json
from rigctl.page.model.story.errors import Unseen, three_figures
from rigctl.page.model.story.plots import before_after
from rigctl.page.model.story.preview import plainest
from rigctl.page.model.story.words import channel
from rigctl.page.model.where import apart
from rigctl.page.parts.widgets import plot


def fell(title: str, before: Unseen, after: Unseen) -> str:
    """Return what adding an effect did to the error."""
    lead = f"With “{title}” the error on shots that the model has not seen goes from "
    if after.floor is None:
        return f"{lead}{before.said()} to {after.said()}."
    told = f"{lead}{three_figures(before.value)} to {three_figures(after.value)} times the noise"
    if after.value <= AT_THE_FLOOR:
        return f"{told}. Nothing can do better: this is the floor."
    return f"{told}; the floor is 1.00."


def changed(before: Json, after: Json) -> None:
    """Place the points without and with the effect beside each other, on the same axes."""
    shown = plainest(before, after)
    if shown is None:
        return
    cell, first, second = shown
    first, second = apart(first), apart(second)
    row = channel(cell["channel"])
    with ui.element("div").classes("columns half"):
        with ui.element("div"):
            ui.label(f"Before: the {row}").classes("strong fails")
            plot(before_after(cell, first, None))
        with ui.element("div"):
            ui.label("After, on the same axes").classes("strong chosen")
            plot(before_after(cell, first, second)).props("data-testid=after")
