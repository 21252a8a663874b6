"""A film of a ball in one picture: its track, flights and bounces over a frame, and its course."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.analysis import AnalysedFilm
from analysis.balls.document import ball_document
from analysis.balls.films.film import Picture
from analysis.balls.measuring import MeasuredBall
from analysis.figures.flights import (
    contacts,
    dots,
    draw_coefficients,
    draw_residuals,
    legend,
    number_bounces,
    pieces,
    ring,
    sheet,
)
from analysis.figures.palette import FAILS, GREY, MEASURED, SPHERE_A

SHOWN_BALLS = 12
BRIGHTEST_PERCENTILE = 99.8
HALF_GREY = 0.5
"""Places are light on frames that are darker for the most part, and dark on others."""


def draw_ball_film(path: Path, title: str, film: AnalysedFilm) -> None:
    """Write the picture of a measured film as PNG.

    One frame with the ball's places, fitted flights and bounces drawn over it; the course of its
    row in time; what is left of the places beside the flights; e of each bounce.
    """
    figure, grid = sheet(title)
    _over_a_frame(figure.add_subplot(grid[:, 0]), film)
    _course(figure.add_subplot(grid[0, 1]), film)
    beside = figure.add_subplot(grid[1, 1])
    beside.set_ylabel("place less flight, px")
    draw_residuals(beside, [flights for _, flights in film.measured.surfaces], ("row", "column"))
    below = figure.add_subplot(grid[2, 1])
    impacts = ball_document(film.measured, ())["impacts"]
    if impacts:
        draw_coefficients(below, impacts)
    else:
        below.axis("off")
        below.text(0.0, 0.9, "\n".join(film.notes), va="top", fontsize=9, wrap=True)
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
        for times, arcs in pieces(flights):
            way = flights.at(times, arcs)
            axes.plot(way[:, 1], way[:, 0], color=FAILS, lw=0.8)
        places = contacts(flights)
        ring(axes, places[:, 1], places[:, 0])
    axes.set_xlim(-0.5, picture.shape[1] - 0.5)
    axes.set_ylim(picture.shape[0] - 0.5, -0.5)
    axes.set_title(f"frame {shown}", fontsize=9, loc="left", color=GREY)
    axes.set_xlabel("column, px")
    axes.set_ylabel("row, px")


def _dots(axes: Axes, measured: MeasuredBall, across: Floats, colour: str) -> None:
    """Draw the ball's rows against something; crosses are places that do not count."""
    rows = measured.placed.places[:, 0]
    every = np.ones(len(rows), dtype=bool)
    counts = every if measured.flights is None else measured.flights.used
    dots(axes, (across, rows), counts, colour)


def _visible(picture: Picture) -> NDArray[np.float64]:
    white = float(np.percentile(picture, BRIGHTEST_PERCENTILE))
    shown = np.clip(picture / max(white, 1.0), 0.0, 1.0)
    return np.asarray(shown[..., ::-1] if shown.shape[2] == 3 else shown[..., 0])


def _course(axes: Axes, film: AnalysedFilm) -> None:
    measured = film.measured
    for one in (measured, *measured.others):
        _dots(axes, one, one.times_s[one.placed.frames], MEASURED)
    for _, flights in measured.surfaces:
        for times, arcs in pieces(flights):
            way = flights.at(times, arcs)
            first = flights is measured.flights and arcs[0] == 0
            axes.plot(
                times - flights.row_delay(way),
                way[:, 0],
                color=FAILS,
                lw=0.8,
                label="flights" if first else None,
            )
    number_bounces(axes, _bounces(measured))
    legend(axes)
    axes.invert_yaxis()
    axes.set_ylabel("row, px")


def _bounces(measured: MeasuredBall) -> Iterator[tuple[float, float]]:
    """Give time on the film's clock and row of each bounce."""
    for _, flights in measured.surfaces:
        places = contacts(flights)
        times = flights.contacts[:, 0] - flights.row_delay(places)
        yield from zip(times.tolist(), places[:, 0].tolist(), strict=True)
