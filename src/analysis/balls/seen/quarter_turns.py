"""What was seen in pictures, as it is seen where they are turned by quarter turns (`np.rot90`)."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np

from analysis.arrays import Floats
from analysis.balls.discs.disc import Disc
from analysis.balls.films.film import Picture
from analysis.balls.seen.looks import Looks

Shape = tuple[int, int]
"""Rows and columns of a picture before it is turned."""

SHADING = np.array([[0, 2, 1, 3, 4, 5], [1, -1, 1, -1, -1, 1]])
"""Of `looks.shaded`: the term that becomes each one by a quarter turn, and its sign."""


def picture_turned(picture: Picture, quarter_turns: int) -> Picture:
    """Return a picture turned, in memory of its own; as it is where it is turned by none."""
    if quarter_turns % 4 == 0:
        return picture
    return cast("Picture", np.ascontiguousarray(np.rot90(picture, quarter_turns)))


def places_turned(places: Floats, shape: Shape, quarter_turns: int) -> Floats:
    """Return row, column and what else is said of each place, shape (N, 3)."""
    rows, columns = shape
    for _ in range(quarter_turns % 4):
        places = np.stack([columns - 1 - places[:, 1], places[:, 0], places[:, 2]], axis=1)
        rows, columns = columns, rows
    return places


def disc_turned(disc: Disc, shape: Shape, quarter_turns: int) -> Disc:
    """Return a disc of a picture in the turned one."""
    ((row, column, _),) = places_turned(
        np.array([[disc.row, disc.column, 0.0]]), shape, quarter_turns
    ).tolist()
    sigmas = disc.row_sigma, disc.column_sigma
    down, across = sigmas[::-1] if quarter_turns % 2 else sigmas
    return replace(disc, row=row, column=column, row_sigma=down, column_sigma=across)


def looks_turned(looks: Looks, shape: Shape, quarter_turns: int) -> Looks:
    """Return how a ball looks in turned pictures: its light comes from another side."""
    shading = looks.shading
    for _ in range(quarter_turns % 4):
        shading = SHADING[1][:, None] * shading[SHADING[0]]
    seen = tuple((frame, disc_turned(disc, shape, quarter_turns)) for frame, disc in looks.seen)
    return replace(looks, shading=shading, seen=seen)
