"""A tracker's table of a ball in one picture: its way, heights, what is left beside them, and e."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from analysis.arrays import Floats
from analysis.balls.document import Json
from analysis.balls.flight.flights import Flights
from analysis.balls.tracks.measuring import MeasuredTrack
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
from analysis.figures.palette import FAILS

MILLI = 1e3
"""Millimetres of a metre."""


def draw_ball_track(path: Path, title: str, track: MeasuredTrack, document: Json) -> None:
    """Write the picture of a measured table as PNG, with lengths in m by its scale.

    The ball's way with flights and bounces; its height in time; what is left of the places beside
    the flights; e of each bounce, as the document of the table has it.
    """
    figure, grid = sheet(title)
    every = [track.flights, *track.beside]
    metres = _Metres.of(every)
    _way(figure.add_subplot(grid[:, 0]), every, metres)
    _heights(figure.add_subplot(grid[0, 1]), every, metres)
    beside = figure.add_subplot(grid[1, 1])
    beside.set_ylabel("place less flight, mm")
    draw_residuals(beside, every, ("downward", "across"), per_px=MILLI / metres.scale)
    draw_coefficients(figure.add_subplot(grid[2, 1]), document["impacts"])
    figure.savefig(path)


@dataclass(frozen=True, slots=True)
class _Metres:
    """Turns a table's places into m: up from the lowest bounce, across from the leftmost place."""

    scale: float
    row: float
    column: float

    @classmethod
    def of(cls, every: Sequence[Flights]) -> _Metres:
        row = max(float(contacts(flights)[:, 0].max()) for flights in every)
        column = min(float(flights.observed.places[:, 1].min()) for flights in every)
        return cls(every[0].scale_px_per_m, row, column)

    def up(self, places: Floats) -> Floats:
        return np.asarray((self.row - places[:, 0]) / self.scale)

    def across(self, places: Floats) -> Floats:
        return np.asarray((places[:, 1] - self.column) / self.scale)


def _way(axes: Axes, every: Sequence[Flights], metres: _Metres) -> None:
    for flights in every:
        places = flights.observed.places
        dots(axes, (metres.across(places), metres.up(places)), flights.used)
        for times, arcs in pieces(flights):
            along = flights.at(times, arcs)
            axes.plot(metres.across(along), metres.up(along), color=FAILS, lw=0.8)
        bounced = contacts(flights)
        ring(axes, metres.across(bounced), metres.up(bounced))
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("across, m")
    axes.set_ylabel("height, m")


def _heights(axes: Axes, every: Sequence[Flights], metres: _Metres) -> None:
    marks: list[tuple[float, float]] = []
    for flights in every:
        heights = metres.up(flights.observed.places)
        dots(axes, (flights.observed.times_s, heights), flights.used)
        for times, arcs in pieces(flights):
            way = flights.at(times, arcs)
            clock = times - flights.row_delay(way)
            axes.plot(clock, metres.up(way), color=FAILS, lw=0.8, label="flights")
        bounced = contacts(flights)
        clock = flights.contacts[:, 0] - flights.row_delay(bounced)
        marks += zip(clock.tolist(), metres.up(bounced).tolist(), strict=True)
    number_bounces(axes, marks)
    legend(axes)
    axes.set_ylabel("height, m")
