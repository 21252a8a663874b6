"""Plots of the page, as figures that the page's own plotting library draws in the browser.

Text, grid and axes take their colours from the style sheet, so that they follow dark and light.
"""

from __future__ import annotations

from collections.abc import Sequence

from analysis.figures.palette import FAILS, FLOOR, MEASURED
from analysis.model.structure.layout import ALARM, BRIGHTEST, columns_of, rows_of, short_label
from rigctl.documents import Json

TOOLS = {
    "displaylogo": False,
    "modeBarButtonsToRemove": [
        "zoom2d",
        "pan2d",
        "select2d",
        "lasso2d",
        "zoomIn2d",
        "zoomOut2d",
        "autoScale2d",
    ],
    "displayModeBar": "hover",
}
CLEAR = "rgba(0,0,0,0)"
LABELS = {"ticklabeloverflow": "allow"}
"""The margins hold the labels; to find out whether each is cut off costs as much as a heat map."""
STRUCTURE = [[0.0, "#F6F1EC"], [0.25, "#F7D9C4"], [0.7, FAILS], [1.0, "#7A3300"]]
LONGEST_LABEL = 34
WIDEST_LABEL = 78
"""Room for the longest number at an axis and its title, px. A plot that finds out by itself how
much it needs is drawn twice."""
ALARMED = "#8A8F98"
"""Frame of a cell beyond `ALARM`: a grey that shows on light and on dark."""


def figure(data: Sequence[Json], height: int, file_name: str, **layout: object) -> Json:
    """Return a figure with the page's margins and the button that saves it as PNG."""
    return {
        "data": list(data),
        "layout": {
            "height": height,
            "margin": {"l": 56, "r": 12, "t": 12, "b": 44},
            "paper_bgcolor": CLEAR,
            "plot_bgcolor": CLEAR,
            # By itself the bar would be half as opaque as the paper is black.
            "modebar": {"bgcolor": CLEAR},
            "font": {"family": 'Inter, system-ui, "Segoe UI", Roboto, sans-serif', "size": 12},
            "showlegend": False,
            "hovermode": "closest",
            "template": {"layout": {"xaxis": LABELS, "yaxis": LABELS}},
            **layout,
        },
        "config": {**TOOLS, "toImageButtonOptions": {"filename": file_name, "scale": 2}},
    }


def heat_map(cells: Sequence[Json], chosen: Json | None, title: str) -> Json:
    """Return quantities against what they may depend on, in standard deviations.

    The mean of each row stands first. Framed: less than 1 % chance with all cells looked at; the
    chosen cell has a blue frame.
    """
    rows = rows_of(str(cell["channel"]) for cell in cells)
    columns = columns_of(str(cell["covariate"]) for cell in cells)
    values: list[list[float | None]] = [[None] * len(columns) for _ in rows]
    chances: list[list[str]] = [[""] * len(columns) for _ in rows]
    frames = []
    for cell in cells:
        row, column = rows.index(cell["channel"]), columns.index(cell["covariate"])
        values[row][column] = round(cell["deviation"], 2)
        chances[row][column] = f"{cell['p_familywise']:.2g}"
        if cell["p_familywise"] < ALARM:
            frames.append(_frame(column, row, ALARMED, 1.6))
    if chosen is not None and chosen in cells:
        place = columns.index(chosen["covariate"]), rows.index(chosen["channel"])
        frames.append(_frame(*place, MEASURED, 3.0))
    trace = {
        "type": "heatmap",
        "x": list(range(len(columns))),
        "y": list(range(len(rows))),
        "z": values,
        "text": chances,
        "texttemplate": "%{z:.0f}",
        "textfont": {"size": 10.5},
        "customdata": [[[row, column] for column in columns] for row in rows],
        "hovertemplate": (
            "%{customdata[0]} against %{customdata[1]}<br>%{z:.1f} standard deviations, "
            "chance with all cells looked at %{text}<extra></extra>"
        ),
        "colorscale": STRUCTURE,
        "zmin": 0,
        "zmax": max([BRIGHTEST, *(cell["deviation"] for cell in cells)]),
        "showscale": False,
        "xgap": 2,
        "ygap": 2,
    }
    axis = {"showgrid": False, "zeroline": False, "fixedrange": True, "tickfont": {"size": 11}}
    return figure(
        [trace],
        62 + 21 * len(rows) + 44,
        f"{title}-structure",
        margin={"l": 132, "r": 8, "t": 4, "b": 84},
        shapes=frames,
        xaxis={
            **axis,
            "tickvals": list(range(len(columns))),
            "ticktext": [short_label(column) for column in columns],
            "tickangle": -45,
        },
        yaxis={
            **axis,
            "tickvals": list(range(len(rows))),
            "ticktext": rows,
            "autorange": "reversed",
        },
    )


def residuals(points: Json, title: str) -> Json:
    """Return the residuals of a cell with their running mean and its two standard errors."""
    x, y, trend = points["x"], points["residual"], points["trend"]
    upper = [m + 2 * s for m, s in zip(trend["mean"], trend["sigma"], strict=True)]
    lower = [m - 2 * s for m, s in zip(trend["mean"], trend["sigma"], strict=True)]
    by_shot = all(frame < 0 for frame in points["frames"])
    scatter = {
        "type": "scatter",
        "mode": "markers",
        "x": x,
        "y": y,
        "customdata": list(zip(points["shots"], points["frames"], strict=True)),
        "marker": {"color": MEASURED, "size": 7 if by_shot else 4, "opacity": 0.75},
        "hovertemplate": (
            "shot %{customdata[0]}"
            + ("" if by_shot else ", frame %{customdata[1]}")
            + f": %{{y:.3g}} {points['unit']}<extra></extra>"
        ),
    }
    if len(x) <= 200:
        scatter["error_y"] = {
            "type": "data",
            "array": points["sigma"],
            "thickness": 0.8,
            "width": 0,
            "color": "rgba(0,114,178,0.35)",
        }
    band = {
        "type": "scatter",
        "x": [*trend["x"], *reversed(trend["x"])],
        "y": [*upper, *reversed(lower)],
        "fill": "toself",
        "fillcolor": "rgba(213,94,0,0.2)",
        "line": {"width": 0},
        "hoverinfo": "skip",
    }
    mean = {
        "type": "scatter",
        "mode": "lines",
        "x": trend["x"],
        "y": trend["mean"],
        "line": {"color": FAILS, "width": 2.2},
        "hoverinfo": "skip",
    }
    return figure(
        [scatter, band, mean],
        330,
        f"{title}-residuals",
        margin={"l": WIDEST_LABEL, "r": 12, "t": 12, "b": 58},
        xaxis={
            "title": {"text": _in_lines(points["x_label"]), "font": {"size": 11.5}},
            "zeroline": False,
        },
        yaxis={"title": {"text": f"residual, {points['unit']}"}},
    )


def error_path(labels: Sequence[str], errors: Sequence[float], bars: Sequence[float]) -> Json:
    """Return the error on shots left out after each effect, and the floor that noise sets."""
    span = [1.0, *errors]
    high, low = max(span), min(span)
    room = max(0.18 * (high - low), 0.02)
    return figure(
        [
            {
                "type": "scatter",
                "mode": "lines+markers+text",
                "x": list(range(len(errors))),
                "y": list(errors),
                "error_y": {"type": "data", "array": list(bars), "color": MEASURED, "width": 4},
                "text": [f"<b>{error:.3f}</b>" for error in errors],
                "textposition": "top right",
                "line": {"color": MEASURED, "width": 2.4, "shape": "hv"},
                "marker": {"size": 10, "color": MEASURED},
                "hovertemplate": "%{y:.4f} of the noise<extra></extra>",
                "cliponaxis": False,
            }
        ],
        204,
        "error-path",
        margin={"l": 52, "r": 14, "t": 10, "b": 46},
        shapes=[
            {
                "type": "line",
                "xref": "paper",
                "x0": 0,
                "x1": 1,
                "y0": 1,
                "y1": 1,
                "line": {"color": FLOOR, "width": 2, "dash": "dash"},
            }
        ],
        xaxis={
            "tickvals": list(range(len(labels))),
            "ticktext": [label.replace("-", "‑") for label in labels],
            "range": [-0.4, max(len(errors), 2) - 0.5],
            "showgrid": False,
            "zeroline": False,
            "fixedrange": True,
        },
        yaxis={
            "title": {"text": "error / noise"},
            "range": [low - room, high + 1.4 * room],
            "fixedrange": True,
            "zeroline": False,
        },
    )


def _frame(column: int, row: int, colour: str, width: float) -> Json:
    return {
        "type": "rect",
        "x0": column - 0.47,
        "x1": column + 0.47,
        "y0": row - 0.47,
        "y1": row + 0.47,
        "line": {"color": colour, "width": width},
    }


def _in_lines(label: str) -> str:
    """Return a label in lines where it is longer than its axis."""
    return label.replace(", ", "<br>") if len(label) > LONGEST_LABEL else label
