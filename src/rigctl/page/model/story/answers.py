"""What the story answers: how wrong the law is, its three numbers, and what an effect mended."""

from __future__ import annotations

import math
from collections.abc import Sequence

from nicegui import ui

from analysis.model.verdict.standing import AT_THE_FLOOR, SURE
from rigctl.documents import Json
from rigctl.page.model.compare import is_unexpected
from rigctl.page.model.story.bars import Bar, bars
from rigctl.page.model.story.cards import Card
from rigctl.page.model.story.errors import Unseen, three_figures
from rigctl.page.model.story.plots import before_after
from rigctl.page.model.story.preview import plainest
from rigctl.page.model.story.where import PLACES
from rigctl.page.model.story.words import channel, sized
from rigctl.page.model.where import apart
from rigctl.page.parts.quantities import EXPECTED
from rigctl.page.parts.tables import minus
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


def changed(before: Json, after: Json, card: Card) -> None:
    """Place the points without and with an effect beside each other, on the same axes."""
    shown = plainest(before, after, PLACES.get(card.where, ""))
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


NAMES = {
    "e": ("bounce e", "speed of parting over speed of approach"),
    "mu": ("friction μ", "push along the surfaces over push along the line of centres"),
    "beta0": ("spin-back β₀", "share of the sliding that is turned round where the surfaces stick"),
}


def law(found: Json) -> None:
    """Place the numbers of the law that an answer has, with a mark at one beyond its range."""
    with ui.element("div").classes("law").props("data-testid=law"):
        for name, (title, meaning) in NAMES.items():
            value = found["parameters"].get(name)
            if value is None or value["value"] is None:
                continue
            unexpected = is_unexpected(value, EXPECTED[name])
            with ui.element("div").classes("unbelieved" if unexpected else "").tooltip(meaning):
                ui.label(title).classes("note")
                said = minus(three_figures(value["value"]))
                ui.label(f"▲ {said}" if unexpected else said).classes("law-value")
                if unexpected:
                    low, high = EXPECTED[name]
                    ui.label(
                        minus(f"believed from {low:g} to {high:g}: something missing may hide here")
                    ).classes("note fails")


LEAST_SPAN = 1.5
"""Errors in units of the noise up to which the scale of the bars goes at least."""


def worst_of(found: Json, worst: Json) -> str:
    """Return how wrong the worst quantity is, in some words."""
    if found.get("estimated"):
        return f"off by {sized(worst)}"
    if worst["p_familywise"] >= SURE:
        return "within the noise"
    times = three_figures(worst["error"])
    return f"off by {sized(worst)}, {times} × the noise"


def error_bars(rows: Sequence[Json], *, estimated: bool) -> None:
    """Place a bar for each quantity; `estimated`: its errors were not stated."""
    if estimated:
        # As multiples of a scatter that is taken for the noise all errors would be about 1.
        for row in rows:
            ui.label(f"{channel(row['quantity'])}: {sized(row)}").classes("strong")
        return
    # From the floor on, in steps of equal ratio: nothing is drawn for what is only noise.
    most = math.log(max(LEAST_SPAN, *(row["error"] for row in rows)))
    bars(
        [
            Bar(
                channel(row["quantity"]),
                math.log(max(1.0, row["error"])) / most,
                f"{three_figures(row['error'])} ×",
                fails=row["p_familywise"] < SURE,
                beside=sized(row),
            )
            for row in rows
        ]
    )


def counted(rows: Sequence[Json]) -> None:
    """Say how many quantities disagree, and how the bars are read."""
    wrong = sum(row["p_familywise"] < SURE for row in rows)
    ui.label(
        f"{wrong} of {len(rows)} quantities disagree. Error on shots that the model has not seen, "
        "as a multiple of the noise; bars begin at 1, the floor. Green may be chance alone."
    ).classes("note")
