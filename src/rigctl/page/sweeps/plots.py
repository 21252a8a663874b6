"""Plots of a sweep: its shots in the plane of pressure and offset, before and while it runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from analysis.errors import counted
from analysis.figures.palette import FAILS, GREY, MEASURED
from rigctl.config import Limits
from rigctl.documents import Json
from rigctl.page.parts.plots import figure
from rigctl.settings import ShotSettings

DIAMETER_MM = 25.4
HEIGHT = 360
SCALE = (0.0, 0.25, 0.5, 1.0, 2.0)
"""Values of v_s / v_n marked beside the offsets."""
MEASURES = "being measured"
LOOKS: dict[str, Json] = {
    "waiting": {"color": "rgba(0,0,0,0)", "size": 10, "line": {"color": GREY, "width": 1.4}},
    "being fired": {"color": "#E69F00", "size": 13, "symbol": "diamond"},
    MEASURES: {"color": GREY, "size": 9, "symbol": "square"},
    "measured": {"color": MEASURED, "size": 10},
    "not measured": {"color": FAILS, "size": 11, "symbol": "triangle-up"},
    "skipped": {"color": GREY, "size": 9, "symbol": "x-thin", "line": {"color": GREY, "width": 2}},
}
"""What may have become of a step, and how it is drawn: never by colour alone."""


SIGNS = {
    "waiting": f'<circle r="5" fill="none" stroke="{GREY}" stroke-width="1.4"/>',
    "being fired": '<path d="M0-7 7 0 0 7-7 0z" fill="#E69F00"/>',
    MEASURES: f'<path d="M-4.5-4.5h9v9h-9z" fill="{GREY}"/>',
    "measured": '<circle r="5" fill="var(--blue)"/>',
    "not measured": f'<path d="M0-6 6 5H-6z" fill="{FAILS}"/>',
    "skipped": f'<path d="M-5-5 5 5M5-5-5 5" stroke="{GREY}" stroke-width="2"/>',
}
"""The same as drawings of a legend."""


def incidence(offset_mm: float) -> float:
    """Return v_s / v_n of spheres that meet without fall or spin: the tangent of arcsin(o / d)."""
    share = min(abs(offset_mm) / DIAMETER_MM, 0.999)
    return share / math.sqrt(1 - share**2)


def covers(steps: Sequence[ShotSettings], turned_until: float | None = None) -> str:
    """Say in words which incidence a sweep's settings mean, and what that rests on.

    Parameters
    ----------
    turned_until
        Ratio up to which friction turned the sliding round in shots measured here; None: not known.
    """
    found = [incidence(step.offset_mm) for step in steps]
    said = (
        f"{counted(len(steps), 'shot')}, sliding ÷ approach from about {min(found):.2f} to "
        f"{max(found):.2f}"
    )
    if turned_until is None:
        return said
    turned = sum(ratio <= turned_until for ratio in found)
    return (
        f"{said}; in {turned} friction turns the sliding round, as in the shots measured here up "
        f"to {turned_until:.2f}"
    )


RESTS_ON = (
    "Sliding ÷ approach is by the offset alone, for spheres that meet level and without spin. "
    "Pressures set how fast they meet; where they are not alike, or b is delayed, the fall shifts "
    "it too."
)
"""What the incidence of settings leaves out."""


def grid(steps: Sequence[ShotSettings], limits: Limits) -> Json:
    """Return the shots that a form means, each setting once, with how often it is fired."""
    shots: dict[tuple[float, float], int] = {}
    for step in steps:
        place = step.pressure_a_kpa, step.offset_mm
        shots[place] = shots.get(place, 0) + 1
    points = {
        "type": "scatter",
        "mode": "markers",
        "x": [pressure for pressure, _ in shots],
        "y": [offset for _, offset in shots],
        "customdata": list(shots.values()),
        "marker": LOOKS["measured"],
        "hovertemplate": "%{x:.1f} kPa, %{y:.2f} mm, %{customdata} times<extra></extra>",
    }
    return _plane([points], limits, "sweep")


def progress(steps: Mapping[str, Sequence[tuple[int, ShotSettings]]], limits: Limits) -> Json:
    """Return the steps of a running sweep by what became of them (a key of `LOOKS`)."""
    return _plane([_fate(name, steps.get(name, ())) for name in LOOKS], limits, "sweep-progress")


def legend(counts: Mapping[str, int]) -> str:
    """Return the legend of `progress` as HTML, with how many steps have each fate.

    It names every fate from the start: one that grew would shift the plot under the hand.
    """
    named = "".join(
        f'<li class="{"" if counts.get(name) else "none"}"><svg viewBox="-8 -8 16 16" '
        f'aria-hidden="true">{SIGNS[name]}</svg>{counts.get(name, 0)} {name}</li>'
        for name in LOOKS
    )
    return f'<ul class="legend">{named}</ul>'


def _fate(name: str, steps: Sequence[tuple[int, ShotSettings]]) -> Json:
    """Return the trace of one fate; one that no step has is drawn nowhere."""
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "x": [settings.pressure_a_kpa for _, settings in steps] or [None],
        "y": [settings.offset_mm for _, settings in steps] or [None],
        "customdata": [number for number, _ in steps],
        "marker": LOOKS[name],
        "hovertemplate": f"step %{{customdata}}, {name}: %{{x:.1f}} kPa, %{{y:.2f}} mm"
        "<extra></extra>",
    }


def _plane(traces: list[Json], limits: Limits, name: str) -> Json:
    low, high = limits.pressure_kpa
    least, most = limits.offset_mm
    across, up = 0.04 * (high - low), 0.06 * (most - least)
    marked = {
        share: offset
        for share in SCALE
        if least <= (offset := DIAMETER_MM * share / math.hypot(1, share)) <= most
    }
    vertical = {"range": [least - up, most + up], "zeroline": False}
    # An axis without a trace is not drawn.
    beside = {"type": "scatter", "x": [None], "y": [None], "yaxis": "y2", "showlegend": False}
    return figure(
        [*traces, beside],
        HEIGHT,
        name,
        margin={"l": 56, "r": 58, "t": 12, "b": 44},
        xaxis={
            "title": {"text": "pressure a, kPa"},
            "range": [low - across, high + across],
            "zeroline": False,
        },
        yaxis={"title": {"text": "offset, mm"}, **vertical},
        yaxis2={
            "title": {"text": "sliding ÷ approach, about"},
            **vertical,
            "overlaying": "y",
            "side": "right",
            "showgrid": False,
            "tickvals": list(marked.values()),
            "ticktext": [f"{share:g}" for share in marked],
        },
    )
