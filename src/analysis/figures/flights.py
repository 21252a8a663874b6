"""What pictures of flights have in common: their ways, bounces, what is left beside them, and e."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.document import Json
from analysis.balls.flight.flights import Flights
from analysis.figures.palette import FAILS, GREY, MEASURED
from analysis.quantity import Quantity

POINTS = 60
LABEL_WIDTH, LABEL_HEIGHT = 70.0, 10.0
"""Of the number and e of a bounce, in points."""


def sheet(title: str) -> tuple[Figure, GridSpec]:
    """Return a figure with a title, and its grid: one column for a way, one for three courses."""
    figure = Figure(figsize=(13.2, 7.6), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title, x=0.01, ha="left", fontsize=14, fontweight="bold")
    return figure, figure.add_gridspec(3, 2, width_ratios=[1.0, 1.4])


def dots(
    axes: Axes, places: tuple[Floats, Floats], counts: NDArray[np.bool_], colour: str = MEASURED
) -> None:
    """Draw places against something, each shape (N,); crosses are those that do not count."""
    across, up = places
    mark(axes, (across[counts], up[counts]), 7.0, color=colour, lw=0, label="places")
    if not counts.all():
        out = across[~counts], up[~counts]
        mark(axes, out, 14.0, marker="x", color=GREY, lw=0.8, label="left out")


def pieces(flights: Flights) -> list[tuple[Floats, NDArray[np.intp]]]:
    """Return times of each flight, of the ball's own row, from contact to contact."""
    times = flights.observed.times_s + flights.row_delay(flights.observed.places)
    ends = [float(times[0]), *flights.contacts[:, 0].tolist(), float(times[-1])]
    return [
        (np.linspace(begin, end, POINTS), np.full(POINTS, arc, dtype=np.intp))
        for arc, (begin, end) in enumerate(pairwise(ends))
    ]


def contacts(flights: Flights) -> Floats:
    """Return row and column of the ball's centre where it meets the plate, shape (bounces, 2)."""
    return flights.at(flights.contacts[:, 0], np.arange(flights.bounces))[:, :2]


def ring(axes: Axes, across: Floats, up: Floats) -> None:
    """Ring bounces where they are."""
    mark(axes, (across, up), 50.0, facecolor="none", edgecolor=FAILS, label="bounces", zorder=3)


def number_bounces(axes: Axes, marks: Iterable[tuple[float, float]]) -> None:
    """Ring bounces on a clock and number them in order of time, as their coefficients are."""
    ordered = sorted(marks)
    if not ordered:
        return
    ring(axes, *np.array(ordered).T)
    for number, place in enumerate(ordered, start=1):
        axes.annotate(
            str(number), place, (0.0, 9.0), textcoords="offset points", fontsize=8, ha="center"
        )


def mark(axes: Axes, places: tuple[Floats, Floats], size: float, **look: Any) -> None:  # noqa: ANN401 - Matplotlib's
    """Draw marks of one size where they are.

    Marks that share one size are drawn at whole pixels, up to one beside the flights: each has its
    own.
    """
    axes.scatter(*places, s=np.full(len(places[0]), size), **look)


def draw_residuals(
    axes: Axes, every: Sequence[Flights], names: tuple[str, str], per_px: float = 1.0
) -> None:
    """Draw what is left of the places beside their flights.

    Parameters
    ----------
    names
        Of the two directions, along the rows' axis and across.
    per_px
        Of the unit in which it is drawn.
    """
    axes.set_xlabel("time, s")
    if not every:
        return
    axes.axhline(0.0, color=GREY, lw=0.6)
    times = np.concatenate([flights.observed.times_s[flights.used] for flights in every])
    left = per_px * np.concatenate([flights.residuals[flights.used] for flights in every])
    for index, (name, colour) in enumerate(zip(names, (MEASURED, GREY), strict=True)):
        axes.plot(times, left[:, index], ".", color=colour, ms=3, label=name)
    legend(axes)


def legend(axes: Axes) -> None:
    """Name what is drawn above the axes: within them the names would lie on the points."""
    named = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    axes.legend(
        named.values(),
        named.keys(),
        fontsize=8,
        frameon=False,
        loc="lower right",
        bbox_to_anchor=(1.0, 0.96),
        ncols=4,
        handletextpad=0.3,
    )


def draw_coefficients(axes: Axes, impacts: Sequence[Json]) -> None:
    """Draw e of each bounce over the speed before it, with its number; as documents have them."""
    speeds = np.array([abs(each["v_n"]["value"]) for each in impacts])
    found = [(each["e"]["value"], each["e"]["sigma"]) for each in impacts]
    for speed, (value, sigma) in zip(speeds.tolist(), found, strict=True):
        axes.errorbar(speed, value, sigma, fmt="o", color=MEASURED, ms=4, capsize=2)
    axes.margins(x=0.2, y=0.3)
    axes.set_xlabel("speed before the bounce, m/s")
    axes.set_ylabel("e")
    _name_bounces(axes, speeds, found)


def _name_bounces(axes: Axes, speeds: Floats, found: Sequence[tuple[float, float]]) -> None:
    """Write number and e of each bounce beside its point, one above the other where they crowd."""
    figure = axes.get_figure(root=True)
    if figure is None:
        return
    # Sizes are known once the axes have their places.
    figure.draw_without_rendering()
    points = axes.transData.transform([(v, e) for v, (e, _) in zip(speeds, found, strict=True)])
    beside = free_heights(72.0 / figure.dpi * points)
    for bounce, (value, sigma) in enumerate(found):
        axes.annotate(
            f"{bounce + 1}: {Quantity(value, sigma, '1').concise()}",
            (float(speeds[bounce]), value),
            (5.0, beside[bounce]),
            textcoords="offset points",
            fontsize=8,
            color=GREY,
            verticalalignment="center",
        )


def free_heights(points: Floats) -> list[float]:
    """Return by how much labels beside points, shape (N, 2), are raised so that none overlap.

    All in points, as fonts are; the label of a point of which no other is near stays at its height.
    """
    taken: list[tuple[float, float]] = []
    raised = []
    for across, up in points.tolist():
        near = [height for place, height in taken if abs(place - across) < LABEL_WIDTH]
        steps = (way * k * LABEL_HEIGHT / 2 for k in range(4 * len(near) + 4) for way in (1, -1))
        free = (s for s in steps if all(abs(up + s - height) >= LABEL_HEIGHT for height in near))
        raised.append(next(free))
        taken.append((across, up + raised[-1]))
    return raised
