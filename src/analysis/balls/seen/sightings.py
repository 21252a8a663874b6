"""Where in each frame something looks like the ball: peaks of a disc-shaped filter."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.films.film import Picture
from analysis.balls.seen.looks import Looks

Singles = NDArray[np.float32]

SOUGHT_RADIUS_PX = 6.0
LEAST_RESPONSE = 0.3
MOST = 6
LEAST_SHRUNK = 2.5
"""Of a sparse picture; less would let fine patterns through."""
CLIP = (-0.3, 1.3)
LEAST_INSIDE = LEAST_RESPONSE + 0.5 * CLIP[0]
"""Of the ball's difference: what one pixel of a disc has at least where the response is large."""


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """Places in one frame, the best first: row, column, response; shape (N, 3)."""

    places: Floats


class Sight:
    """Looks for a ball of known looks in one frame after another.

    Parameters
    ----------
    looks
        Radius and channel.
    ground
        What stands still.
    """

    def __init__(self, looks: Looks, ground: Picture) -> None:
        self._factor = max(1.0, looks.radius_px / SOUGHT_RADIUS_PX)
        self._weights = looks.weights.astype(np.float32)[None]
        # Where many pixels make one, every second row and column tells as well.
        self._stride = max(1, int(self._factor / LEAST_SHRUNK))
        # Whole numbers of pixels are put together many times as fast as parts of them.
        self._together = max(1, round(self._factor / self._stride))
        self._factor = float(self._stride * self._together)
        self._ground = self._small(ground)
        self._radius = looks.radius_px / self._factor
        self._kernel = _disc_less_ring(self._radius)

    def _small(self, picture: Picture) -> Singles:
        small: NDArray[np.generic] = picture
        if self._factor > 1.0:
            rows, columns = (side // int(self._factor) for side in picture.shape[:2])
            own = picture[: rows * int(self._factor), : columns * int(self._factor)]
            sparse = (columns * self._together, rows * self._together)
            nearest = cv2.resize(own, sparse, interpolation=cv2.INTER_NEAREST)
            size = (columns, rows)
            small = np.atleast_3d(cv2.resize(nearest, size, interpolation=cv2.INTER_AREA))
        return np.asarray(cv2.transform(small.astype(np.float32), self._weights), dtype=np.float32)

    def find(self, picture: Picture, brighter: float = 1.0) -> Sightings:
        """Return where something of the ball's size and colour differs from the ground.

        Parameters
        ----------
        brighter
            The picture's values over those of what stands still.
        """
        difference = np.clip(self._small(picture) / brighter - self._ground, *CLIP)
        box = self._changed(difference)
        border = cv2.BORDER_CONSTANT
        filtered = cv2.filter2D(difference[box], cv2.CV_32F, self._kernel, borderType=border)
        response = np.asarray(filtered, dtype=np.float32)
        width = 2 * round(0.7 * self._radius) + 1
        top = cv2.dilate(response, np.ones((width, width), np.uint8))
        rows, columns = np.nonzero((response >= top) & (response >= LEAST_RESPONSE))
        strength = response[rows, columns]
        order = np.argsort(-strength)[:MOST]
        places = np.empty((len(order), 3))
        for k, index in enumerate(order.tolist()):
            row, column = _peak(response, int(rows[index]), int(columns[index]))
            places[k] = (
                (row + box[0].start + 0.5) * self._factor - 0.5 * self._stride,
                (column + box[1].start + 0.5) * self._factor - 0.5 * self._stride,
                strength[index],
            )
        return Sightings(places)

    def _changed(self, difference: Singles) -> tuple[slice, slice]:
        """Return rows and columns beyond which no response is large: most of it stands still.

        A disc whose mean and half of whose ring's make LEAST_RESPONSE has a pixel of LEAST_INSIDE.
        """
        strong = difference >= LEAST_INSIDE
        reach = 3 * self._kernel.shape[0] // 2
        sides = []
        for axis in (1, 0):
            lines = np.flatnonzero(strong.any(axis=axis)).tolist() or [0]
            sides.append(slice(max(0, lines[0] - reach), lines[-1] + reach + 1))
        return sides[0], sides[1]


def _disc_less_ring(radius: float) -> Singles:
    reach = int(np.ceil(1.6 * radius))
    row, column = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    away = np.hypot(row, column)
    disc = np.clip(radius - away + 0.5, 0.0, 1.0)
    ring = ((away > 1.2 * radius) & (away <= 1.6 * radius)).astype(np.float64)
    kernel = disc / disc.sum() - 0.5 * ring / max(ring.sum(), 1.0)
    return np.asarray(kernel, dtype=np.float32)


def _peak(response: Singles, row: int, column: int) -> tuple[float, float]:
    rows, columns = response.shape
    place = []
    for at, most, line in (
        (row, rows, response[:, column]),
        (column, columns, response[row, :]),
    ):
        shift = 0.0
        if 0 < at < most - 1:
            before, here, after = (float(v) for v in line[at - 1 : at + 2])
            curve = before - 2 * here + after
            if curve < 0:
                shift = min(0.5, max(-0.5, 0.5 * (before - after) / curve))
        place.append(at + shift)
    return place[0], place[1]
