"""Plots of a campaign: figure 7.4 of the thesis, and restitution over speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from analysis.figures.palette import FAILS, FLOOR, MEASURED
from rigctl.page.plots import figure

Json = dict[str, Any]
HEIGHT = 340
ERROR_BAR = {"type": "data", "thickness": 0.9, "width": 0, "color": "rgba(0,114,178,0.4)"}


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


def restitution(found: Sequence[tuple[int, Json, Json]], title: str) -> Json:
    """Return e over |v_n|; `found` has the number, v_n and e of each shot."""
    return figure(
        [
            {
                "type": "scatter",
                "mode": "markers",
                "x": [-v["value"] for _, v, _ in found],
                "y": [e["value"] for _, _, e in found],
                "error_y": {**ERROR_BAR, "array": [e["sigma"] for _, _, e in found]},
                "customdata": [number for number, _, _ in found],
                "marker": {"color": MEASURED, "size": 7},
                "hovertemplate": "shot %{customdata}: %{x:.3f} m/s, %{y:.4f}<extra></extra>",
            }
        ],
        HEIGHT,
        f"{title}-restitution",
        xaxis={"title": {"text": "|v_n| before contact, m/s"}, "zeroline": False},
        yaxis={"title": {"text": "normal restitution e"}, "zeroline": False, "automargin": True},
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
