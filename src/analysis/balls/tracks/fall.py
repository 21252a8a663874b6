"""The free fall in a table of places: which axis is the vertical, its direction and its size."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError

LENGTHS = (6, 9, 13, 19, 27, 39, 57, 83, 121, 175)
"""Places of a piece through which a parabola is laid."""
LEAST_PIECES, LEAST_SHARE = 3, 0.1
"""That bend alike, and of all that scatter as little."""
SCATTERED = 1.5
"""Scatter of a piece over that of the shortest ones: what scatters more goes over a bounce."""
CLEAR = 5.0
"""Errors by which a piece that falls bends."""
MOST_UNSURE = 0.3
"""Error of a fall, as a share of it, that is none."""


@dataclass(frozen=True, slots=True)
class TableFall:
    """How things fall in a table.

    Attributes
    ----------
    axis
        Of the vertical: 0, 1 or 2 for x, y or z.
    size
        Units a second squared; positive where things fall towards larger numbers.
    scatter
        Of places about a free fall, units.
    """

    axis: int
    size: float
    scatter: float


def table_fall(times_s: Floats, places: Floats) -> TableFall:
    """Return the fall that most pieces of a track show.

    A piece over a bounce is no parabola; the longer one that is, the better it tells the fall.

    Parameters
    ----------
    times_s, places
        In order of time, shapes (N,) and (N, axes).

    Raises
    ------
    ShotRefusedError
        No axis bends in one way throughout.
    """
    found = [_along(times_s, places[:, axis]) for axis in range(places.shape[1])]
    sizes = [abs(bend) if unsure < MOST_UNSURE * abs(bend) else 0.0 for bend, unsure, _ in found]
    if not any(sizes):
        raise ShotRefusedError(
            "flight",
            "nothing in the table falls freely: no axis bends alike in most places; check that "
            "frames or times are those of the camera, and that the ball flies",
        )
    axis = int(np.argmax(sizes))
    return TableFall(axis, found[axis][0], max(scatter for _, _, scatter in found))


def _along(times_s: Floats, values: Floats) -> tuple[float, float, float]:
    """Return the bend of the longest pieces that are parabolas, its error, and their scatter."""
    found = 0.0, np.inf
    scatter = 0.0
    for length in LENGTHS:
        pieces = _pieces(times_s, values, length)
        if not len(pieces):
            break
        if length == LENGTHS[0]:
            # Most of the shortest pieces lie between bounces.
            scatter = float(np.median(pieces[:, 1]))
        bends, _, errors = pieces[pieces[:, 1] <= SCATTERED * scatter].T
        if len(bends) < LEAST_PIECES:
            break
        # A ball that is held or rests does not bend, however long it does.
        clear = np.abs(bends) > CLEAR * scatter * errors
        way = np.sign(np.sum(np.sign(bends[clear])))
        smooth = len(bends)
        bends, errors = (each[clear & (np.sign(bends) == way)] for each in (bends, errors))
        # A few over a bounce that turns a ball aside a little bend too.
        if len(bends) < max(LEAST_PIECES, LEAST_SHARE * smooth):
            continue
        middle = float(np.median(bends))
        spread = 1.4826 * float(np.median(np.abs(bends - middle)))
        found = middle, max(spread, scatter * float(np.median(errors)))
    return *found, scatter


def _pieces(times_s: Floats, values: Floats, length: int) -> Floats:
    """Return the acceleration of each piece of so many places, its scatter, and its error by that.

    The error is that of places that scatter by one unit; shape (N, 3).
    """
    found = []
    for first in range(len(values) - length + 1):
        own = slice(first, first + length)
        lasts = float(np.ptp(times_s[own]))
        if lasts <= 0.0:
            continue
        unit = (times_s[own] - times_s[own].mean()) / lasts
        design = np.stack([np.ones(length), unit, unit**2], axis=1)
        inverse = np.linalg.pinv(design)
        fitted = inverse @ values[own]
        left = values[own] - design @ fitted
        scatter = math.sqrt(float(left @ left) / (length - design.shape[1]))
        bent = 2.0 / lasts**2
        found.append((bent * fitted[2], scatter, bent * float(np.linalg.norm(inverse[2]))))
    return np.array(found).reshape(-1, 3)
