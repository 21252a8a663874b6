"""Step 1 of the story: how wrong each quantity is, as bars and in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

from nicegui import ui

from analysis.model.verdict.standing import SURE
from rigctl.documents import Json
from rigctl.page.model.story.bars import Bar, bars
from rigctl.page.model.story.errors import three_figures
from rigctl.page.model.story.words import channel, sized

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
