"""Plots of measured shots: restitution over speed, and over how far the surfaces slide."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.figures.palette import FLOOR, MEASURED
from rigctl.documents import Json
from rigctl.page.parts.empty_plots import NO_SHOTS, NO_SLIDING, empty
from rigctl.page.parts.plots import figure
from rigctl.page.parts.readings import Impact

HEIGHT = 340
LEAST_SPAN = 0.1
"""Speeds that differ by less, m/s, do not fill the axis: its labels would be all places."""
ERROR_BAR = {"type": "data", "thickness": 0.9, "width": 0, "color": "rgba(0,114,178,0.4)"}


def over_speed(found: Sequence[Impact], title: str, none: str = NO_SHOTS) -> Json:
    """Return e over |v_n| of measured shots; `none` is said where there are none."""
    told = [(one.number, one.v_n[0], *one.e) for one in found if one.v_n and one.e]
    if not told:
        return empty(none, HEIGHT, f"{title}-restitution")
    return figure(
        [_shots([(n, abs(v), e, s) for n, v, e, s in told], "m/s")],
        HEIGHT,
        f"{title}-restitution",
        xaxis={
            "title": {"text": "approach speed |v<sub>n</sub>|, m/s"},
            "zeroline": False,
            "range": _span([abs(v) for _, v, _, _ in told]),
        },
        yaxis={"title": {"text": "bounce e"}, "zeroline": False, "automargin": True},
    )


def over_incidence(found: Sequence[Impact], title: str, none: str = NO_SHOTS) -> Json:
    """Return beta over v_s / |v_n|; shots that hardly slide, and tell nothing of it, left out.

    `none` is said where there are no shots.
    """
    told = [
        (one.number, one.incidence, *one.beta)
        for one in found
        if one.incidence is not None and one.beta is not None and one.beta[1] < 1
    ]
    if not told:
        return empty(NO_SLIDING if found else none, HEIGHT, f"{title}-tangential")
    return figure(
        [_shots(told, "")],
        HEIGHT,
        f"{title}-tangential",
        shapes=[_level(-1.0, "β = −1: no friction")],
        xaxis={
            "title": {"text": "sliding ÷ approach, v<sub>s</sub> / |v<sub>n</sub>|"},
            "rangemode": "tozero",
        },
        yaxis={
            "title": {"text": "spin-back β"},
            "range": [-1.1, 0.1 + max(0.9, *(beta for _, _, beta, _ in told))],
            "zeroline": False,
            "automargin": True,
        },
    )


def _span(values: Sequence[float]) -> list[float]:
    low, high = min(values), max(values)
    room = max(0.06 * (high - low), (LEAST_SPAN - (high - low)) / 2)
    return [low - room, high + room]


def _shots(told: Sequence[tuple[int, float, float, float]], unit: str) -> Json:
    return {
        "type": "scatter",
        "mode": "markers",
        "x": [x for _, x, _, _ in told],
        "y": [y for _, _, y, _ in told],
        "error_y": {**ERROR_BAR, "array": [sigma for _, _, _, sigma in told]},
        "customdata": [number for number, _, _, _ in told],
        "marker": {"color": MEASURED, "size": 7},
        "hovertemplate": f"shot %{{customdata}}: %{{x:.3f}} {unit}, %{{y:.4f}}<extra></extra>",
    }


def _level(height: float, name: str) -> Json:
    # A name as an annotation would look as if it could be pressed.
    return {
        "type": "line",
        "xref": "paper",
        "x0": 0,
        "x1": 1,
        "y0": height,
        "y1": height,
        "line": {"color": FLOOR, "width": 1.4, "dash": "dot"},
        "label": {
            "text": name,
            "textposition": "end",
            "yanchor": "bottom",
            "font": {"size": 11},
        },
    }
