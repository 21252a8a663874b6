"""A film of a ball in one picture: its track, flights and bounces over a frame, and its course."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.analysis import AnalysedFilm
from analysis.balls.films.film import Picture
from analysis.balls.flight.flights import Flights
from analysis.balls.measuring import MeasuredBall, coefficient
from analysis.figures.palette import FAILS, GREY, MEASURED, SPHERE_A
from analysis.quantity import Quantity

SHOWN_BALLS = 12
POINTS = 60
BRIGHTEST_PERCENTILE = 99.8
HALF_GREY = 0.5
"""Places are light on frames that are darker for the most part, and dark on others."""
LABEL_WIDTH, LABEL_HEIGHT = 70.0, 10.0
"""Of the number and e of a bounce, in points."""


def draw_ball_film(path: Path, title: str, film: AnalysedFilm) -> None:
    """Write the picture of a measured film as PNG.

    One frame with the ball's places, fitted flights and bounces drawn over it; the course of its
    row in time; what is left of the places beside the flights; e of each bounce.
    """
    figure = Figure(figsize=(13.2, 7.6), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title, x=0.01, ha="left", fontsize=14, fontweight="bold")
    grid = figure.add_gridspec(3, 2, width_ratios=[1.0, 1.4])
    _over_a_frame(figure.add_subplot(grid[:, 0]), film)
    _course(figure.add_subplot(grid[0, 1]), film)
    _residuals(figure.add_subplot(grid[1, 1]), film)
    _coefficients(figure.add_subplot(grid[2, 1]), film)
    figure.savefig(path)


def _over_a_frame(axes: Axes, film: AnalysedFilm) -> None:
    measured = film.measured
    placed = measured.placed
    shown = int(placed.frames[len(placed.frames) // 2])
    picture = film.film.chosen([shown])[shown]
    visible = _visible(picture)
    axes.imshow(visible, cmap="gray", interpolation="nearest")
    colour = SPHERE_A if np.median(visible) < HALF_GREY else MEASURED
    chosen = np.linspace(0, len(placed.frames) - 1, SHOWN_BALLS).round().astype(int)
    for row, column in placed.places[np.unique(chosen)]:
        axes.add_patch(
            Circle((column, row), measured.looks.radius_px, fill=False, color=colour, lw=0.9)
        )
    for one in (measured, *measured.others):
        _dots(axes, one, one.placed.places[:, 1], colour)
    for _, flights in measured.surfaces:
        for times, arcs in _pieces(flights):
            way = flights.at(times, arcs)
            axes.plot(way[:, 1], way[:, 0], color=FAILS, lw=0.8)
        places = _contacts(flights)
        _ring(axes, places[:, 1], places[:, 0])
    axes.set_xlim(-0.5, picture.shape[1] - 0.5)
    axes.set_ylim(picture.shape[0] - 0.5, -0.5)
    axes.set_title(f"frame {shown}", fontsize=9, loc="left", color=GREY)
    axes.set_xlabel("column, px")
    axes.set_ylabel("row, px")


def _dots(axes: Axes, measured: MeasuredBall, across: Floats, colour: str) -> None:
    """Draw the ball's rows against something; crosses are places that do not count."""
    rows = measured.placed.places[:, 0]
    counts = np.ones(len(rows), dtype=bool)
    if measured.flights is not None:
        counts = measured.flights.used
    mark(axes, (across[counts], rows[counts]), 7.0, color=colour, lw=0, label="places")
    if not counts.all():
        out = across[~counts], rows[~counts]
        mark(axes, out, 14.0, marker="x", color=GREY, lw=0.8, label="left out")


def _ring(axes: Axes, across: Floats, rows: Floats) -> None:
    mark(axes, (across, rows), 50.0, facecolor="none", edgecolor=FAILS, label="bounces", zorder=3)


def mark(axes: Axes, places: tuple[Floats, Floats], size: float, **look: Any) -> None:  # noqa: ANN401 - Matplotlib's
    """Draw marks of one size where they are.

    Marks that share one size are drawn at whole pixels, up to one beside the flights: each has its
    own.
    """
    axes.scatter(*places, s=np.full(len(places[0]), size), **look)


def _visible(picture: Picture) -> NDArray[np.float64]:
    white = float(np.percentile(picture, BRIGHTEST_PERCENTILE))
    shown = np.clip(picture / max(white, 1.0), 0.0, 1.0)
    return np.asarray(shown[..., ::-1] if shown.shape[2] == 3 else shown[..., 0])


def _pieces(flights: Flights) -> list[tuple[Floats, NDArray[np.intp]]]:
    """Return times of each flight, of the ball's own row, from contact to contact."""
    times = flights.observed.times_s + flights.row_delay(flights.observed.places)
    ends = [float(times[0]), *flights.contacts[:, 0].tolist(), float(times[-1])]
    return [
        (np.linspace(begin, end, POINTS), np.full(POINTS, arc, dtype=np.intp))
        for arc, (begin, end) in enumerate(pairwise(ends))
    ]


def _contacts(flights: Flights) -> Floats:
    """Return row and column of the ball's centre where it meets the plate, shape (bounces, 2)."""
    return flights.at(flights.contacts[:, 0], np.arange(flights.bounces))[:, :2]


def _course(axes: Axes, film: AnalysedFilm) -> None:
    measured = film.measured
    for one in (measured, *measured.others):
        _dots(axes, one, one.times_s[one.placed.frames], MEASURED)
    for _, flights in measured.surfaces:
        for times, arcs in _pieces(flights):
            way = flights.at(times, arcs)
            first = flights is measured.flights and arcs[0] == 0
            axes.plot(
                times - flights.row_delay(way),
                way[:, 0],
                color=FAILS,
                lw=0.8,
                label="flights" if first else None,
            )
    _mark_bounces(axes, measured)
    _legend(axes)
    axes.invert_yaxis()
    axes.set_ylabel("row, px")


def _mark_bounces(axes: Axes, measured: MeasuredBall) -> None:
    """Ring the bounces on the film's clock, and number them as their coefficients are."""
    marks: list[tuple[float, float]] = []
    for _, flights in measured.surfaces:
        places = _contacts(flights)
        times = flights.contacts[:, 0] - flights.row_delay(places)
        marks += zip(times.tolist(), places[:, 0].tolist(), strict=True)
    if not marks:
        return
    _ring(axes, *np.array(marks).T)
    for number, (time, row) in enumerate(sorted(marks), start=1):
        axes.annotate(
            str(number),
            (time, row),
            (0.0, 9.0),
            textcoords="offset points",
            fontsize=8,
            ha="center",
        )


def _residuals(axes: Axes, film: AnalysedFilm) -> None:
    axes.set_ylabel("place less flight, px")
    axes.set_xlabel("time, s")
    every = [flights for _, flights in film.measured.surfaces]
    if not every:
        return
    axes.axhline(0.0, color=GREY, lw=0.6)
    times = np.concatenate([flights.observed.times_s[flights.used] for flights in every])
    left = np.concatenate([flights.residuals[flights.used] for flights in every])
    for index, (name, colour) in enumerate((("row", MEASURED), ("column", GREY))):
        axes.plot(times, left[:, index], ".", color=colour, ms=3, label=name)
    _legend(axes)


def _legend(axes: Axes) -> None:
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


def _coefficients(axes: Axes, film: AnalysedFilm) -> None:
    flights = film.measured.flights
    if flights is None:
        axes.axis("off")
        axes.text(0.0, 0.9, "\n".join(film.notes), va="top", fontsize=9, wrap=True)
        return
    each = sorted(
        (
            (
                float(own.contacts[k, 0]),
                own.contacts[k, 1] / own.scale_px_per_m,
                coefficient(one, k),
            )
            for one, own in film.measured.surfaces
            for k in range(own.bounces)
        ),
        key=lambda bounce: bounce[0],
    )
    speeds = np.array([speed for _, speed, _ in each])
    found = [e for _, _, e in each]
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
