"""How a picture has moved since another one of its film: by the light of all that stands still."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.films.film import Picture
from analysis.imaging.fields import grey

LEVELS, LEAST_SIDE = 4, 60
"""Sizes of a picture, each half of the one before, and px of the smallest."""
CELLS, IN_CELL = 12, 60
"""Parts of each side of a picture, and pixels of each whose light changes most along it."""
STEEP, LEAST_STEEP = 4.0, 1.0
"""Least change of light from pixel to pixel, in what noise changes and in grey levels of 200, of a
pixel that shows where a picture is."""
OF_NOISE = 0.2
"""Of the noise of pixels: what a change of light has of it, once blurred by a pixel."""
SECOND = np.array([[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]])
"""Takes noise alone out of a picture (Immerkaer, 1996)."""
LEAST_CELLS, LEAST_SPAN, LEAST_REACH = 6, 0.6, 0.4
"""Parts with such pixels, and how far they reach, of each side and of one: a hand or a ball reaches
less far."""
STEPS, SETTLED_PX = 12, 0.003
TUKEY = 4.685
LEAST_NOISE = 1.0
"""Grey levels of 200."""
APART, APART_SIGMAS = 0.35, 4.0
"""Of a shift, and in errors: by how much that of a quarter may differ, as of what is nearer."""
MATTERS = 0.05
"""Of what is left of a part's light: a smaller change says nothing."""
MOST_TURN, MOST_SIGMA_PX = 0.03, 0.05
"""Turn and change of scale of a camera's move (radians), and the error of its shift."""


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """How a picture has moved from the first one.

    Attributes
    ----------
    numbers
        Scale less 1, turn, shift right and down of the picture's middle (radians, px), shape (4,).
    sigma_px
        Standard error of the shift.
    better
        Share of the picture's parts that lie better so than unmoved.
    """

    numbers: Floats
    sigma_px: float
    better: float

    @property
    def sure(self) -> bool:
        """Return whether a hand or a stand moves a camera so."""
        size = float(np.abs(self.numbers[:2]).max())
        return size < MOST_TURN and self.sigma_px < MOST_SIGMA_PX


@dataclass(frozen=True, slots=True, eq=False)
class _Level:
    """Steep pixels of the first picture in one size.

    Attributes
    ----------
    places
        Column and row from the picture's middle, shape (N, 2).
    values
        Grey levels there, shape (N,).
    slopes
        What scale, turn, shift, gain and offset add to them, shape (N, 6).
    cells
        Part of the picture of each, shape (N,).
    middle
        Column and row of the picture's middle.
    """

    places: Floats
    values: Floats
    slopes: Floats
    cells: NDArray[np.intp]
    middle: Floats


class Reference:
    """A picture in which others are found again: where its light changes, and by how much."""

    def __init__(self, picture: Picture) -> None:
        self._top = float(np.percentile(grey(picture)[::4, ::4], 99.5))
        first = _scaled(picture, self._top)
        rough = np.abs(cv2.filter2D(first, -1, SECOND))
        steep = STEEP * OF_NOISE * 1.4826 * float(np.median(rough)) / 6.0
        self._levels = [_level(each, max(LEAST_STEEP, steep)) for each in _sizes(first)]
        self.shows = _shows(self._levels[0], max(LEAST_STEEP, steep))

    def moved(self, picture: Picture, start: Floats) -> Move | None:
        """Return how a picture has moved; None where too little of it is seen again.

        Parameters
        ----------
        start
            Numbers of a move nearby, shape (4,).
        """
        sizes = _sizes(_scaled(picture, self._top))
        numbers, covariance = _through(self._levels, sizes, start)
        finest = self._levels[0]
        left = _left(finest, sizes[0], numbers)
        still = np.concatenate([np.zeros(4), numbers[4:]])
        unmoved = _left(finest, sizes[0], still)
        if not np.isfinite(numbers).all() or not len(left):
            return None
        sigma = math.sqrt(float(covariance[2, 2] + covariance[3, 3]))
        return Move(numbers[:4], sigma, _better(finest.cells, left, unmoved))

    def agreed(self, picture: Picture, move: Move) -> bool:
        """Return whether each quarter of a picture has moved as all of it has.

        A codec carries the noise of a dark picture along from one whole picture to the next: what
        is fitted to it is a move of its own in each part.
        """
        sizes = _sizes(_scaled(picture, self._top))
        for quarter in range(4):
            levels = [_quarter(level, quarter) for level in self._levels]
            if len(np.unique(levels[0].cells)) < LEAST_CELLS:
                continue
            numbers, covariance = _through(levels, sizes, move.numbers)
            middle = levels[0].places.mean(axis=0)
            own, whole = (_shift(each, middle) for each in (numbers, move.numbers))
            sigma = math.sqrt(float(covariance[2, 2] + covariance[3, 3]))
            size = max(math.hypot(*own), math.hypot(*whole))
            if not math.hypot(*(own - whole)) < APART * size + APART_SIGMAS * sigma:
                return False
        return True


def _through(levels: list[_Level], sizes: list[Singles], start: Floats) -> tuple[Floats, Floats]:
    """Return the move, gain and offset of a picture from its smallest size to its own.

    With their covariance; shapes (6,) and (6, 6).
    """
    numbers, covariance = np.concatenate([start, [1.0, 0.0]]), np.eye(6)
    for depth, (level, own) in reversed(list(enumerate(zip(levels, sizes, strict=True)))):
        if len(level.values) < IN_CELL:
            continue  # Nothing is left of fine light in small sizes.
        numbers[2:4] /= 2.0**depth
        numbers, covariance = _settled(level, own, numbers)
        numbers[2:4] *= 2.0**depth
    return numbers, covariance


def _quarter(level: _Level, quarter: int) -> _Level:
    """Return the pixels of one quarter of a picture."""
    lower, right = level.cells // CELLS >= CELLS // 2, level.cells % CELLS >= CELLS // 2
    own = (2 * lower + right) == quarter
    return replace(
        level,
        places=level.places[own],
        values=level.values[own],
        slopes=level.slopes[own],
        cells=level.cells[own],
    )


def _shift(numbers: Floats, place: Floats) -> Floats:
    """Return by how much a move shifts a place, column and row from the middle, px."""
    scale, turn, right, down = numbers[:4].tolist()
    x, y = place.tolist()
    return np.array([scale * x - turn * y + right, scale * y + turn * x + down])


def _better(cells: NDArray[np.intp], left: Floats, unmoved: Floats) -> float:
    """Return the share of parts that a move explains better, of those for which it matters.

    None are where those do not reach far: along stripes, or an edge that is all of a wall, any
    shift is as good, and what else moves decides.
    """
    found = np.unique(cells)
    own, still = (_medians(np.abs(each), cells) for each in (left, unmoved))
    better, worse = own < (1.0 - MATTERS) * still, own > (1.0 + MATTERS) * still
    if max(_reach(found[better])) < LEAST_REACH:
        return 0.0
    return float(better.sum() / (better.sum() + worse.sum()))


def _medians(values: Floats, cells: NDArray[np.intp]) -> Floats:
    """Return the median of each part's values, in the order of the parts' numbers."""
    order = np.lexsort((values, cells))
    _, first, count = np.unique(cells[order], return_index=True, return_counts=True)
    lower, upper = (values[order[first + each // 2]] for each in (count - 1, count))
    return np.asarray(0.5 * (lower + upper))


def _shows(level: _Level, least: float) -> bool:
    """Return whether parts of a picture show a shift, most of it over, and in every direction.

    Along stripes, or along an edge that is all of a wall, light changes by noise alone, and what
    moves by itself would decide.
    """
    slopes, found = level.slopes[:, 2:4], np.unique(level.cells)
    if min(_reach(found)) < LEAST_SPAN:
        return False
    ways = np.linalg.eigh(slopes.T @ slopes)[1]
    along = np.array([((slopes[level.cells == cell] @ ways) ** 2).mean(axis=0) for cell in found])
    return all(max(_reach(found[own > (0.5 * least) ** 2])) > LEAST_REACH for own in along.T)


def _reach(cells: NDArray[np.intp]) -> tuple[float, float]:
    """Return over which share of a picture's height and width parts reach; (0, 0) of few."""
    if len(cells) < LEAST_CELLS:
        return 0.0, 0.0
    return float(np.ptp(cells // CELLS) / CELLS), float(np.ptp(cells % CELLS) / CELLS)


def _scaled(picture: Picture, top: float) -> Singles:
    return np.asarray(grey(picture) * (200.0 / max(top, 1.0)), dtype=np.float32)


def _sizes(picture: Singles) -> list[Singles]:
    """Return a picture a little blurred, and in half of the size again and again."""
    sizes = [np.asarray(cv2.GaussianBlur(picture, (0, 0), 1.0), dtype=np.float32)]
    while len(sizes) < LEVELS and min(sizes[-1].shape) >= 2 * LEAST_SIDE:
        sizes.append(np.asarray(cv2.pyrDown(sizes[-1]), dtype=np.float32))
    return sizes


def _level(picture: Singles, least: float) -> _Level:
    """Return the steepest pixels of a picture's parts, of those steeper than the least."""
    rows, columns = picture.shape
    right = 0.5 * (picture[1:-1, 2:] - picture[1:-1, :-2])
    down = 0.5 * (picture[2:, 1:-1] - picture[:-2, 1:-1])
    steep = np.hypot(right, down)
    chosen, cells = [], []
    edges = [np.linspace(0, side, CELLS + 1).astype(int) for side in steep.shape]
    for i in range(CELLS):
        for j in range(CELLS):
            part = steep[edges[0][i] : edges[0][i + 1], edges[1][j] : edges[1][j + 1]]
            best = np.argsort(part, axis=None)[::-1][:IN_CELL]
            best = best[part.flat[best] > least]
            if len(best) < IN_CELL // 4:
                continue
            row, column = np.unravel_index(best, part.shape)
            chosen.append(np.stack([row + edges[0][i], column + edges[1][j]]))
            cells.append(np.full(len(best), i * CELLS + j))
    if not chosen:
        chosen, cells = [np.empty((2, 0), dtype=int)], [np.empty(0, dtype=int)]
    row, column = np.concatenate(chosen, axis=1)
    middle = 0.5 * (np.array([columns, rows], dtype=float) - 1.0)
    places = np.stack([column + 1, row + 1], axis=1) - middle
    u, v = right[row, column].astype(float), down[row, column].astype(float)
    values = picture[row + 1, column + 1].astype(float)
    x, y = places.T
    slopes = np.stack([u * x + v * y, v * x - u * y, u, v, values, np.ones(len(x))], axis=1)
    return _Level(places, values, slopes, np.concatenate(cells), middle)


def _left(level: _Level, picture: Singles, numbers: Floats) -> Floats:
    """Return the first picture's grey levels less a moved one's, shape (N,)."""
    scale, turn, right, down, gain, offset = numbers.tolist()
    x, y = level.places.T
    columns = x + scale * x - turn * y + right + level.middle[0]
    rows = y + scale * y + turn * x + down + level.middle[1]
    seen = cv2.remap(
        picture,
        columns.astype(np.float32)[:, None],
        rows.astype(np.float32)[:, None],
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return np.asarray(gain * level.values + offset - seen[:, 0], dtype=np.float64)


def _settled(level: _Level, picture: Singles, numbers: Floats) -> tuple[Floats, Floats]:
    """Return numbers that leave the least, what moves by itself left out, and their covariance."""
    design = level.slopes.copy()
    reach = float(np.abs(level.middle).max())
    scales = np.array([1.0 / reach, 1.0 / reach, 1.0, 1.0, 1.0 / 100.0, 1.0])
    design[:, 4:] *= -1.0
    design *= scales
    square = np.eye(6)
    for _ in range(STEPS):
        left = _left(level, picture, numbers)
        size = max(LEAST_NOISE, 1.4826 * float(np.median(np.abs(left))))
        share = np.minimum(1.0, np.abs(left) / (TUKEY * size))
        weights = (1.0 - share**2) ** 2
        square = design.T @ (weights[:, None] * design) + 1e-9 * np.eye(6)
        step = scales * np.linalg.solve(square, design.T @ (weights * left))
        numbers = numbers + step
        if math.hypot(*step[2:4]) < SETTLED_PX and np.abs(step[:2]).max() * reach < SETTLED_PX:
            break
    covariance = size**2 * np.linalg.inv(square) * np.outer(scales, scales)
    return numbers, np.asarray(covariance)
