"""Figure 7.4 of the thesis: a campaign's rebound of the surface velocity."""

from __future__ import annotations

from typing import Any

from analysis.figures.palette import FAILS, FLOOR, MEASURED
from rigctl.page.parts.impact_plots import ERROR_BAR, HEIGHT
from rigctl.page.parts.plots import figure

Json = dict[str, Any]


def plane(found: Json, title: str) -> Json:
    """Return v_s' / |v_n| over v_s / |v_n|: shots, Walton's two lines, Maw's curve."""
    reach = 1.08 * max([*found["x"], 0.1])
    laws = [
        _law("Walton, two lines", found, "walton", {"color": FAILS, "width": 2.2}),
        _law("Maw, Barber, Fawcett", found, "maw", {"color": FLOOR, "width": 2.2, "dash": "dash"}),
    ]
    shots = {
        "type": "scatter",
        "mode": "markers",
        "name": "shots",
        "x": found["x"],
        "y": found["y"],
        "error_y": {**ERROR_BAR, "array": found["sigma"]},
        "customdata": found["shots"],
        "marker": {"color": MEASURED, "size": 7},
        "hovertemplate": "shot %{customdata}: %{x:.3f}, %{y:.3f}<extra></extra>",
    }
    inside = [y for x, y in zip(found["law_x"], found["walton"], strict=True) if x <= reach]
    low, high = min([*inside, *found["y"]]), max([*inside, *found["y"]])
    room = 0.12 * (high - low)
    return figure(
        [*laws, shots],
        HEIGHT,
        f"{title}-figure-7-4",
        showlegend=True,
        legend={"x": 0.02, "y": 0.98, "bgcolor": "rgba(0,0,0,0)"},
        xaxis={"title": {"text": "v_s / |v_n| before contact"}, "range": [0, reach]},
        yaxis={
            "title": {"text": "v_s′ / |v_n| after contact"},
            "range": [low - room, high + room],
        },
    )


def _law(name: str, found: Json, key: str, line: Json) -> Json:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": found["law_x"],
        "y": found[key],
        "line": line,
        "hoverinfo": "skip",
    }
