"""How bright each frame is: cameras set their exposure anew while they film, and lamps flicker."""

from __future__ import annotations

from typing import cast

import numpy as np

from analysis.balls.films.film import FilmHead, Picture
from analysis.balls.films.tone import light

SEEN_PIXELS = 6_000
"""Of a picture, evenly spread; what moves covers less than half of them."""
LEAST_LEVEL = 0.1
"""Of the largest value of what stands still: darker pixels are mostly noise."""
STEADY = 0.01
"""Changes below this are none: what stands still tells them no better."""


class Brightness:
    """Compares pictures with what stands still, by the median ratio of their values.

    Parameters
    ----------
    ground
        What stands still, shape (rows, columns, channels).
    head
        Of the film: whether its values follow a tone curve.
    """

    def __init__(self, ground: Picture, head: FilmHead) -> None:
        self._head = head
        still = some_pixels(ground)
        most = np.iinfo(ground.dtype).max
        top = min(float(still.max(initial=1)), 0.95 * most)
        self._seen = (still > LEAST_LEVEL * top) & (still < 0.95 * most)
        self._still = still[self._seen]
        self._light = light(self._still, head)

    def of(self, picture: Picture) -> tuple[float, float]:
        """Return how much brighter a picture is than the ground: its values, and its light."""
        own = some_pixels(picture)[self._seen]
        if len(own) == 0:
            return 1.0, 1.0
        values = float(np.median(own / self._still.astype(np.float32)))
        if abs(values - 1.0) < STEADY:
            return 1.0, 1.0
        ratios = np.maximum(light(own, self._head), 1e-3) / np.maximum(self._light, 1e-3)
        return values, float(np.median(ratios))


def some_pixels(picture: Picture) -> Picture:
    """Return one channel of the pixels that are compared, evenly spread over a picture."""
    step = max(1, int((picture.shape[0] * picture.shape[1] / SEEN_PIXELS) ** 0.5))
    return picture[::step, ::step, picture.shape[2] // 2]


def evened(picture: Picture, values: float) -> Picture:
    """Return a picture as bright as the ground, given how much brighter its values are."""
    if values == 1.0:
        return picture
    most = np.iinfo(picture.dtype).max
    even = np.rint(picture.astype(np.float32) / values)
    return cast("Picture", np.clip(even, 0, most).astype(picture.dtype))
