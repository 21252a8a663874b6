"""Where in a frame something looks like a known ball: a disc of its light before any ground.

What a ball changes at a pixel is its own light less the ground's there: before one ground it is
brighter, before another one darker or of another hue. With the change D of a frame, and the change
E that the ball would make at a place, the response there is the least-squares share of E in D,
<D, E> / <E, E>; where more has changed than the ball would, the correlation of both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.films.film import Picture
from analysis.balls.seen.looks import Looks, shaded

Singles = NDArray[np.float32]
Real = TypeVar("Real", np.float32, np.float64)

SOUGHT_RADIUS_PX = 6.0
LEAST_RESPONSE = 0.3
MOST = 6
LEAST_SHRUNK = 2.5
"""Of a sparse picture; less would let fine patterns through."""
SHADE = 0.3
"""Standard deviation of a ground's light in shadows that come and go, over its light."""
COARSE_RADIUS_PX, COARSER = 6.0, 2.0
"""Balls of this size and more are sought in pixels twice as large first, where no pixels are put
together otherwise: a quarter of the picture and of the disc, and then about what was seen alone."""
FIRST_RESPONSE, FIRST_MOST = 0.5 * LEAST_RESPONSE, 2 * MOST
"""Of what is seen so: less, and more of it, than is kept."""
HILL_RADII = 0.7
"""From the place of a response to one that is another's."""
TINY = 1e-6
BESIDE, RING = 0.5, (1.2, 1.6)
"""What a pixel beside the ball counts of one within it, and how far that reaches, radii."""


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """Places in one frame, the best first: row, column, response; shape (N, 3)."""

    places: Floats


class Sight:
    """Looks for a ball of known looks in one frame after another.

    Channels are made independent and of one error each, by what the ball's shading leaves of its
    values. In the direction of the ground's own colour a shadow's depth is error too.

    Parameters
    ----------
    looks
        Radius and light.
    ground
        What stands still, shape (rows, columns, channels).
    factor
        Rows and columns that are one at least.
    """

    def __init__(self, looks: Looks, ground: Picture, factor: float = 1.0) -> None:
        small = factor == 1.0 and looks.radius_px >= COARSE_RADIUS_PX
        factor = max(factor, looks.radius_px / SOUGHT_RADIUS_PX)
        # Where many pixels make one, every second row and column tells as well.
        self._stride = max(1, int(factor / LEAST_SHRUNK))
        # Whole numbers of pixels are put together many times as fast as parts of them.
        self._together = max(1, round(factor / self._stride))
        self._factor = float(self._stride * self._together)
        self._white = np.linalg.inv(np.linalg.cholesky(looks.spread)).astype(np.float32)
        self._ground = self._small(ground)
        self._radius = looks.radius_px / self._factor
        self._disc, self._about = _disc_and_ring(self._radius)
        self._reach = math.ceil((1.0 + HILL_RADII) * self._radius) + self._about.shape[0] // 2
        self._ball = self._light(looks)
        damped = 1.0 / (1.0 + SHADE**2 * (self._ground.astype(np.float64) ** 2).sum(axis=2))
        expected = np.maximum(self._energy(damped), TINY)
        noise = self._energy(damped**2) / expected
        self._damped, self._expected = damped.astype(np.float32), expected.astype(np.float32)
        # A ball that differs from its ground by its own errors is half seen.
        self._unseen = (self._disc.sum() * noise + TINY).astype(np.float32)
        self._first = None
        if small and self._factor == 1.0:
            self._first = Sight(looks, ground, COARSER)
        bound = (expected + self._unseen) ** 2 / expected
        self._bound = bound.astype(np.float32)

    def _small(self, picture: Picture) -> Singles:
        small: NDArray[np.generic] = picture
        if self._factor > 1.0:
            rows, columns = (side // int(self._factor) for side in picture.shape[:2])
            own = picture[: rows * int(self._factor), : columns * int(self._factor)]
            sparse = (columns * self._together, rows * self._together)
            nearest = cv2.resize(own, sparse, interpolation=cv2.INTER_NEAREST)
            size = (columns, rows)
            small = np.atleast_3d(cv2.resize(nearest, size, interpolation=cv2.INTER_AREA))
        white = cv2.transform(small.astype(np.float32), self._white)
        return np.asarray(np.atleast_3d(white), dtype=np.float32)

    def _light(self, looks: Looks) -> Singles:
        """Return the ball's light at each pixel of its disc, shape (side, side, channels)."""
        reach = self._disc.shape[0] // 2
        row, column = np.mgrid[-reach : reach + 1, -reach : reach + 1] / self._radius
        limb = np.maximum(1.0, np.hypot(row, column))
        light = shaded(row / limb, column / limb) @ looks.shading @ self._white.T
        return np.asarray(self._disc[..., None] * light, dtype=np.float32)

    def _energy(self, damped: Floats) -> Floats:
        """Return <E, E> of a whole ball at each pixel of the ground.

        Parameters
        ----------
        damped
            What counts of a square along the ground's own colour, shape (rows, columns).
        """
        # Nearly all of it may cancel.
        ground, ball, disc = (
            np.asarray(each, dtype=np.float64) for each in (self._ground, self._ball, self._disc)
        )
        brightness = np.maximum((ground**2).sum(axis=2), TINY)
        share = 1.0 / np.maximum(disc, TINY)
        whole = float((ball**2 * share[..., None]).sum()) + _filtered(damped * brightness, disc)
        for c in range(ground.shape[2]):
            whole -= 2.0 * _filtered(damped * ground[..., c], ball[..., c])
            for d in range(ground.shape[2]):
                lost = (1.0 - damped) / brightness * ground[..., c] * ground[..., d]
                whole -= _filtered(lost, share * ball[..., c] * ball[..., d])
        return np.maximum(whole, 0.0)

    def find(self, picture: Picture, brighter: float = 1.0) -> Sightings:
        """Return where something of the ball's size and light differs from the ground.

        Parameters
        ----------
        brighter
            The picture's values over those of what stands still.
        """
        if self._first is None:
            return Sightings(self._peaks(picture, brighter, LEAST_RESPONSE, MOST)[0])
        first, pixels = self._first._peaks(picture, brighter, FIRST_RESPONSE, FIRST_MOST)
        if COARSER**2 * pixels < len(first) * (2 * self._reach + 1) ** 2:
            return Sightings(self._peaks(picture, brighter, LEAST_RESPONSE, MOST)[0])
        found: dict[tuple[int, int], Floats] = {}
        for place in first:
            found |= self._near(picture, brighter, place)
        places = sorted(found.values(), key=lambda each: -float(each[2]))[:MOST]
        return Sightings(np.array(places, dtype=np.float64).reshape(-1, 3))

    def _peaks(
        self, picture: Picture, brighter: float, least: float, most: int
    ) -> tuple[Floats, int]:
        """Return row, column and response where it is largest, shape (N, 3), of how many pixels."""
        change = self._small(picture) / np.float32(brighter) - self._ground
        along = _product(change, self._ground)
        strength = self._strength(change, along, self._damped)
        box = self._changed(strength, least)
        response = self._response(change[box], along[box], strength[box], box)
        rows, columns = np.nonzero(self._highest(response) & (response >= least))
        found = response[rows, columns]
        order = np.argsort(-found)[:most]
        places = np.empty((len(order), 3))
        for k, index in enumerate(order.tolist()):
            row, column = _peak(response, int(rows[index]), int(columns[index]))
            places[k] = (
                (row + box[0].start + 0.5) * self._factor - 0.5 * self._stride,
                (column + box[1].start + 0.5) * self._factor - 0.5 * self._stride,
                found[index],
            )
        return places, response.size

    def _near(
        self, picture: Picture, brighter: float, place: Floats
    ) -> dict[tuple[int, int], Floats]:
        """Return the responses about a place by their pixels, of pixels as they are."""
        around, reach = math.ceil(self._radius), self._reach
        middle = [round(float(each)) for each in place[:2]]
        box = tuple(
            slice(max(0, at - reach), min(side, at + reach + 1))
            for at, side in zip(middle, picture.shape[:2], strict=True)
        )
        ground, damped = self._ground[box], self._damped[box]
        change = self._small(picture[box]) / np.float32(brighter) - ground
        along = _product(change, ground)
        strength = self._strength(change, along, damped)
        response = self._response(change, along, strength, (box[0], box[1]))
        found = {}
        peaks = np.nonzero(self._highest(response) & (response >= LEAST_RESPONSE))
        for own in zip(*(each.tolist() for each in peaks), strict=True):
            pixel = own[0] + box[0].start, own[1] + box[1].start
            if max(abs(pixel[0] - middle[0]), abs(pixel[1] - middle[1])) <= around:
                row, column = _peak(response, *own)
                at = row + box[0].start, column + box[1].start
                found[pixel] = np.array([*at, float(response[own])])
        return found

    def _strength(self, change: Singles, along: Singles, damped: Singles) -> Singles:
        """Return the square of a change at each pixel, less what a shadow makes of it."""
        return np.asarray(_product(change, change) - SHADE**2 * damped * along**2)

    def _highest(self, response: Singles) -> NDArray[np.bool_]:
        """Return where no response near by is larger."""
        width = 2 * round(HILL_RADII * self._radius) + 1
        return np.asarray(response >= cv2.dilate(response, np.ones((width, width), np.uint8)))

    def _response(
        self, change: Singles, along: Singles, strength: Singles, box: tuple[slice, slice]
    ) -> Singles:
        """Return the share of the ball's change in that of a frame, or their correlation."""
        damped, ground, expected = self._damped[box], self._ground[box], self._expected[box]
        alike = -_filtered(damped * along, self._disc, cv2.BORDER_CONSTANT)
        shade = SHADE**2 * damped * along
        for c in range(ground.shape[2]):
            own = change[..., c] - shade * ground[..., c]
            alike += _filtered(own, self._ball[..., c], cv2.BORDER_CONSTANT)
        seen = np.maximum(_filtered(strength, self._about, cv2.BORDER_CONSTANT), 0.0)
        most = np.sqrt(expected * np.maximum(expected, seen))
        return np.asarray(alike / (most + self._unseen[box]), dtype=np.float32)

    def _changed(self, strength: Singles, least: float) -> tuple[slice, slice]:
        """Return rows and columns beyond which no response is so large: most of it stands still.

        By <D, E>^2 <= <D, D> <E, E>, with <D, D> of the square about a disc.
        """
        reach = self._about.shape[0] // 2
        side = 2 * math.ceil(self._radius) + 1
        square = cv2.boxFilter(
            strength, -1, (side, side), normalize=False, borderType=cv2.BORDER_CONSTANT
        )
        strong = square >= least**2 * self._bound
        sides = []
        for axis in (1, 0):
            lines = np.flatnonzero(strong.any(axis=axis)).tolist() or [0]
            sides.append(slice(max(0, lines[0] - reach), lines[-1] + reach + 1))
        return sides[0], sides[1]


def _product(left: Singles, right: Singles) -> Singles:
    """Return the product of two layers at each pixel, summed over channels; shape (rows, columns).

    A third of the time of `einsum`, whose loop is over so few channels.
    """
    each = np.atleast_3d(cv2.multiply(left, right))
    return np.asarray(cv2.transform(each, np.ones((1, each.shape[2]), np.float32)))


def _filtered(
    layer: NDArray[Real], kernel: NDArray[Real], border: int = cv2.BORDER_REPLICATE
) -> NDArray[Real]:
    """Return the sum of a layer's pixels about each, as a kernel weighs them."""
    return cast("NDArray[Real]", cv2.filter2D(layer, -1, kernel, borderType=border))


def _disc_and_ring(radius: float) -> tuple[Singles, Singles]:
    """Return the share of each pixel that a disc covers, and the same with what lies about it."""
    inner, outer = RING
    reach = int(np.ceil(outer * radius))
    row, column = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    away = np.hypot(row, column)
    disc = np.clip(radius - away + 0.5, 0.0, 1.0).astype(np.float32)
    ring = (away > inner * radius) & (away <= outer * radius)
    return disc, disc + np.float32(BESIDE) * ring


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
