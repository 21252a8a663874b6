"""The points of a cell as they are drawn: wherever any lies, and none upon another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

Json = dict[str, Any]

ALL_DRAWN = 300
"""So few points are drawn each, with their error bars."""
ACROSS, UP = 60, 48
"""Places in a plot, each a little larger than a marker; one point is drawn in each."""
BY_POINT = ("shots", "frames", "x", "residual", "sigma")


def apart(points: Json) -> Json:
    """Return a cell's points without those that a plot would draw upon an earlier one.

    Half of a thousand points lie upon others; a browser takes as long to draw them as all the rest
    of the plot. The running mean keeps what it was made of.
    """
    if len(points["x"]) <= ALL_DRAWN:
        return points
    places = zip(_places(points["x"], ACROSS), _places(points["residual"], UP), strict=True)
    first: dict[tuple[int, int], int] = {}
    for index, place in enumerate(places):
        first.setdefault(place, index)
    return {**points, **{name: [points[name][i] for i in first.values()] for name in BY_POINT}}


def _places(values: Sequence[float], count: int) -> list[int]:
    """Return in which of `count` equal places of their range each value lies."""
    low, high = min(values), max(values)
    step = (high - low) / count or 1.0
    return [int((value - low) / step) for value in values]
