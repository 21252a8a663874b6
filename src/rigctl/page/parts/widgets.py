"""Buttons as every page has them."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from typing import Any

from nicegui import ui


def button(
    text: str, on_click: Callable[..., Any], *, look: str = "line", testid: str = "", icon: str = ""
) -> ui.button:
    """Place a button; `look` is `line`, `fill` or `fire`, with `main` for one across its panel."""
    placed = ui.button(text, on_click=on_click, color=None, icon=icon or None)
    placed.props("unelevated no-caps dense").classes(look)
    return placed.props(f"data-testid={testid}") if testid else placed


def save_csv(name: str, rows: Callable[[], Sequence[Sequence[object]]]) -> None:
    """Place the button that saves a plot's or a table's numbers as CSV."""

    def save() -> None:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows())
        ui.download.content(text.getvalue(), f"{name}.csv", "text/csv")

    placed = ui.button("CSV", on_click=save, color=None).props("flat dense no-caps").classes("save")
    placed.tooltip("save these numbers as CSV")


def plot(figure: dict[str, Any]) -> ui.plotly:
    """Place a figure of `plots`; its height stands fast, its width is that of its panel."""
    placed = ui.plotly(figure).classes("plot")
    # Without a height of its own the plot would take its panel's, which takes the plot's.
    return placed.style(f"height: {figure['layout']['height']}px")


def redraw(placed: ui.plotly, figure: dict[str, Any]) -> None:
    """Draw another figure over one that `plot` placed."""
    placed.style(f"height: {figure['layout']['height']}px")
    placed.update_figure(figure)
