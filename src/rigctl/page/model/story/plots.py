"""Plots of the story: one cell, with the curve that the slider moves, before and after."""

from __future__ import annotations

import math
from collections.abc import Sequence
from textwrap import wrap

from analysis.figures.palette import FAILS, FLOOR, GREY, MEASURED
from analysis.model.structure.findings import ALWAYS
from analysis.model.structure.layout import covariate_label
from rigctl.documents import Json
from rigctl.page.model.story.errors import Unseen
from rigctl.page.model.story.words import covariate
from rigctl.page.parts.plots import WIDEST_LABEL, figure

HEIGHT = 320
LEAST_TICKS = 3
ORDER_LABEL = covariate_label("order")
LETTERS = 30
"""Of the names of all treads of the staircase, beside each other on a telephone."""
UNITS_OF_LOGARITHMS = {"ln v_n": "m/s", "ln v_s/v_n": ""}


def cell_plot(
    cell: Json,
    points: Json,
    curve: tuple[Sequence[float], Sequence[float]],
    ringed: int | None = None,
) -> Json:
    """Return measured less model of a cell, with a curve over it; one shot may be ringed."""
    drawn = [_shots(points, MEASURED, 0.6), _line(curve)]
    own = [k for k, shot in enumerate(points["shots"]) if shot == ringed]
    if own:
        at = [points["x"][k] for k in own], [points["residual"][k] for k in own]
        drawn.append(_ring(*at, by_shot=len(own) == 1))
    return _plot(drawn, cell, points)


def dots_plot(cell: Json, points: Json, line: Sequence[float] = ()) -> Json:
    """Return measured less model of a cell; `line` is what `line_plot` draws at the best size."""
    return _plot([_shots(points, MEASURED, 0.6)], cell, points, line)


def line_plot(cell: Json, points: Json, x: Sequence[float], line: Sequence[float]) -> Json:
    """Return a line at zero on the axes of `dots_plot`, to lie over it.

    A slider redraws this one alone: the dots, a thousand of them, take several times as long.
    """
    drawn = _plot([_line((x, [0.0] * len(x)))], cell, points, line)
    for axis in ("xaxis", "yaxis"):
        drawn["layout"][axis]["visible"] = False
    drawn["layout"]["shapes"] = []
    drawn["config"] = {"staticPlot": True}
    return drawn


def staircase(labels: Sequence[str], errors: Sequence[Unseen], tried: Unseen | None) -> Json:
    """Return the error on unseen shots as steps down to the floor, which is the noise itself.

    Parameters
    ----------
    labels, errors
        Of the model as it is, without and with each effect.
    tried
        The error with the effect that is looked at and not added; None: not known.
    """
    floor = errors[0].floor
    treads = [one.value for one in (*errors, *([] if tried is None else [tried]))]
    lowest = 0.0 if floor is None else floor
    high, low = max(lowest, *treads), min(lowest, *treads)
    room = max(0.12 * (high - low), 0.01)
    step = {"type": "scatter", "mode": "lines+text", "hoverinfo": "skip", "cliponaxis": False}
    x = [value for k in range(len(errors)) for value in (k, k + 0.5, k + 1)]
    y = [error.value for error in errors for _ in range(3)]
    texts = ["", "", ""] * len(errors)
    texts[1::3] = [f"<b>{error.said()}</b>" for error in errors]
    drawn = [
        {**step, "x": x, "y": y, "text": texts, "textposition": "top center"}
        | {"line": {"color": MEASURED, "width": 4}, "textfont": {"size": 15}}
        | {"fill": "tozeroy", "fillcolor": "rgba(0, 114, 178, 0.08)"},
    ]
    names = list(labels)
    if tried is not None:
        count = len(errors)
        drawn.append(
            {**step, "x": [count, count + 0.5, count + 1], "y": [tried.value] * 3}
            | {"text": ["", tried.said(), ""], "textposition": "top center"}
            | {"line": {"color": GREY, "width": 3, "dash": "dot"}}
        )
        names.append("looked at")
    noise = {"type": "rect", "xref": "paper", "x0": 0, "x1": 1, "y0": low - 2 * room, "y1": floor}
    noise |= {"fillcolor": FLOOR, "opacity": 0.16, "line": {"width": 0}}
    return figure(
        drawn,
        282,
        "staircase",
        margin={"l": WIDEST_LABEL, "r": 12, "t": 18, "b": 76},
        shapes=[] if floor is None else [noise],
        xaxis={
            "tickvals": [k + 0.5 for k in range(len(names))],
            "ticktext": [_in_lines(name, max(LETTERS // max(len(names), 2), 1)) for name in names],
            "tickangle": 0,
            "range": [0, max(len(names), 2)],
            "zeroline": False,
            "showgrid": False,
        },
        yaxis={
            "title": {"text": f"error, {errors[0].unit}" if floor is None else "error ÷ noise"},
            "range": [low - room, high + 2 * room],
            "zeroline": False,
        },
    )


def before_after(cell: Json, before: Json, after: Json | None) -> Json:
    """Return what the model lacks, on the axes of `before`: without an effect, or with it.

    With it the points without it stand behind, grey.
    """
    if after is None:
        return _plot([_shots(before, FAILS, 0.8)], cell, before)
    return _plot([_shots(before, GREY, 0.5), _shots(after, MEASURED, 0.8)], cell, before)


def _plot(traces: list[Json], cell: Json, points: Json, line: Sequence[float] = ()) -> Json:
    seen = [0.0, *points["residual"], *line]
    low, high = min(seen), max(seen)
    room = 0.06 * (high - low)
    left, right = min(points["x"]), max(points["x"])
    beside = 0.04 * (right - left)
    zero = {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": 0, "y1": 0}
    return figure(
        traces,
        HEIGHT,
        "story",
        margin={"l": WIDEST_LABEL, "r": 12, "t": 12, "b": 62},
        shapes=[{**zero, "line": {"color": FLOOR, "width": 2}}],
        xaxis={
            "title": {"text": _axis(cell, points).replace(" (", "<br>(")},
            "range": [left - beside, right + beside],
            **_ticks(cell, points, left - beside, right + beside),
            "zeroline": False,
        },
        yaxis={
            "title": {"text": f"measured − model, {points['unit']}"},
            "range": [low - room, high + room],
            "zeroline": False,
        },
    )


def _line(curve: tuple[Sequence[float], Sequence[float]]) -> Json:
    return {
        "type": "scatter",
        "mode": "lines",
        "x": list(curve[0]),
        "y": list(curve[1]),
        "line": {"color": FAILS, "width": 3},
        "hoverinfo": "skip",
    }


def _ring(x: list[float], y: list[float], *, by_shot: bool) -> Json:
    """Return what marks a shot: a ring round its one point, or its many frames filled."""
    ring = {"symbol": "circle-open", "size": 15, "line": {"width": 2.5}}
    return {
        "type": "scatter",
        "mode": "markers",
        "x": x,
        "y": y,
        "marker": {"color": FAILS, **(ring if by_shot else {"size": 6})},
        "hoverinfo": "skip",
    }


def _axis(cell: Json, points: Json) -> str:
    """Return the covariate in plain words with its unit, as the label of the points states it."""
    label = str(points["x_label"])
    if label == ORDER_LABEL:
        return covariate("order")
    _, comma, unit = label.rpartition(", ")
    if cell["covariate"] == ALWAYS:
        return label
    plain = covariate(cell["covariate"])
    if cell["covariate"] in UNITS_OF_LOGARITHMS:
        unit = UNITS_OF_LOGARITHMS[cell["covariate"]]
        comma = unit
    return f"{plain}, {unit}" if comma else plain


def _ticks(cell: Json, points: Json, left: float, right: float) -> Json:
    """Return the ticks of a logarithm at round numbers of what it is taken of; else nothing.

    Of the order of firing they are the first shot and the last.
    """
    if points["x_label"] == ORDER_LABEL:
        # Its places are shares of the campaign, from minus a half on: no number that is read.
        ends = [min(points["x"]), max(points["x"])]
        return {"tickvals": ends, "ticktext": ["first shot", "last shot"]}
    if cell["covariate"] not in UNITS_OF_LOGARITHMS:
        return {}
    decades = range(-4, 4)
    round_numbers = [digit * 10.0**power for power in decades for digit in (1, 2, 5)]
    shown = [value for value in round_numbers if left <= math.log(value) <= right]
    if len(shown) < LEAST_TICKS:
        shown = [float(f"{math.exp(left + k * (right - left) / 4):.2g}") for k in range(5)]
    return {"tickvals": [math.log(v) for v in shown], "ticktext": [f"{v:g}" for v in shown]}


def _in_lines(name: str, letters: int) -> str:
    """Return the name of a tread in lines of about so many letters."""
    return "<br>".join(wrap(name, letters, break_long_words=False))


def _shots(points: Json, colour: str, opacity: float) -> Json:
    by_shot = all(frame < 0 for frame in points["frames"])
    return {
        "type": "scatter",
        "mode": "markers",
        "x": points["x"],
        "y": points["residual"],
        "customdata": points["shots"],
        "marker": {"color": colour, "size": 7 if by_shot else 4, "opacity": opacity},
        "hovertemplate": f"shot %{{customdata}}: %{{y:.3g}} {points['unit']}<extra></extra>",
    }
