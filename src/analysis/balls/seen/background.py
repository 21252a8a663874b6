"""What stands still in a film, which pixels of a frame differ, and how bright each frame is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from analysis import threads
from analysis.balls.films.film import FilmHead, Picture
from analysis.balls.films.tone import light
from analysis.compiled import compiled

Singles = NDArray[np.float32]

BLOCK = 16384
"""Pixels whose values of all frames fit into a processor's cache."""
SEEN_LINES = 240
"""Rows and columns whose pixels show the noise of all."""
CHANGED_SIGMAS = 6.0
"""In noises of a pixel: what differs by more has changed."""


def background(samples: list[Picture]) -> Picture:
    """Return the median of some frames, of their shape and kind."""
    shape = samples[0].shape
    return cast("Picture", _medians([each.reshape(-1) for each in samples]).reshape(shape))


def noise_of(samples: Sequence[Picture], ground: Picture) -> float:
    """Return the standard deviation of a pixel that stands still, one grey level at least."""
    # A part of the pixels tells as well.
    step = max(1, min(ground.shape[:2]) // SEEN_LINES)
    middle = ground[::step, ::step].astype(np.float32)
    spreads = [
        float(np.median(np.abs(sample[::step, ::step].astype(np.float32) - middle)))
        for sample in samples[::4]
    ]
    return max(1.0, 1.4826 * float(np.median(spreads)))


def changed(picture: Picture, ground: Picture, noise: float) -> NDArray[np.bool_]:
    """Return which pixels differ from what stands still in any channel, shape (rows, columns).

    Parameters
    ----------
    noise
        Standard deviation of a pixel that stands still.
    """
    found = np.empty(picture.shape[:2], dtype=np.bool_)
    most = int(CHANGED_SIGMAS * noise)
    _differ(np.ascontiguousarray(picture), np.ascontiguousarray(ground), most, found)
    return found


def changes(
    samples: Mapping[int, Picture], ground: Picture, noise: float
) -> dict[int, NDArray[np.bool_]]:
    """Return `changed` of each of some frames."""
    each = threads.each(lambda picture: changed(picture, ground, noise), samples.values())
    return dict(zip(samples, each, strict=True))


@compiled
def _differ(
    picture: NDArray[Any], ground: NDArray[Any], most: int, found: NDArray[np.bool_]
) -> None:
    """Fill in which pixels differ by more than so many grey levels in any channel."""
    rows, columns, channels = picture.shape
    for i in range(rows):
        for j in range(columns):
            found[i, j] = False
            for c in range(channels):
                found[i, j] |= abs(np.int32(picture[i, j, c]) - np.int32(ground[i, j, c])) > most


def background_without(samples: Sequence[Singles], hidden: Sequence[NDArray[np.bool_]]) -> Singles:
    """Return the median of some frames where none of them shows the ball.

    Parameters
    ----------
    samples
        Light of each, shape (rows, columns).
    hidden
        Of each, where the ball is; shape (rows, columns). A pixel that it hides in all keeps the
        median of all.
    """
    flat = np.stack(samples).reshape(len(samples), -1)
    mask = np.stack(hidden).reshape(len(samples), -1)
    return np.asarray(_seen_medians(flat, mask).reshape(samples[0].shape))


def _seen_medians(values: Singles, hidden: NDArray[np.bool_]) -> Singles:
    """Return the median of what is not hidden in each column; of all where all is.

    The mean of the two in the middle: the upper one of two is half a standard deviation too bright,
    and a ball that stays near its plate leaves few frames in which the ground beside it is seen.
    """
    seen = len(values) - hidden.sum(axis=0)
    shown = np.where(hidden & (seen > 0), np.float32(np.inf), values)
    count = np.where(seen > 0, seen, len(values))
    middle = np.stack([(count - 1) // 2, count // 2])
    found = np.empty(values.shape[1], values.dtype)
    for start, lines in _sorted(list(shown)):
        block = slice(start, start + lines.shape[1])
        found[block] = np.take_along_axis(lines, middle[:, block], axis=0).mean(axis=0)
    return found


def _medians(values: list[Picture]) -> Picture:
    """Return the upper median of each column of some lines."""
    middle = len(values) // 2
    return np.concatenate([lines[middle] for _, lines in _sorted(values, middle)])


def _sorted(
    values: Sequence[NDArray[Any]], line: int | None = None
) -> Iterator[tuple[int, NDArray[Any]]]:
    """Give each block of columns, sorted, and its first column.

    Each comparison is one of whole lines: a processor does many of them at once.

    Parameters
    ----------
    line
        The one that is wanted: the others may then be out of order.
    """
    count, width = len(values), len(values[0])
    pairs = _needed(_network(count), set(range(count)) if line is None else {line})
    network = np.array(pairs, dtype=np.intp).reshape(-1, 2)
    for start in range(0, width, BLOCK):
        lines = np.stack([each[start : start + BLOCK] for each in values])
        _compare(lines, network)
        yield start, lines


@compiled
def _compare(lines: NDArray[Any], network: NDArray[np.intp]) -> None:
    """Put the lesser value of each pair of lines, column by column, into the first of them."""
    for k in range(len(network)):
        first, second = lines[network[k, 0]], lines[network[k, 1]]
        for j in range(lines.shape[1]):
            a, b = first[j], second[j]
            first[j], second[j] = min(a, b), max(a, b)


def _needed(network: list[tuple[int, int]], wanted: set[int]) -> list[tuple[int, int]]:
    """Return the pairs on which wanted lines depend."""
    kept = []
    for a, b in reversed(network):
        if a in wanted or b in wanted:
            kept.append((a, b))
            wanted = wanted | {a, b}
    return kept[::-1]


def _network(count: int) -> list[tuple[int, int]]:
    """Return pairs that, compared in this order, sort so many values (Batcher, 1968)."""
    pairs = []
    merged = 1
    while merged < count:
        apart = merged
        while apart >= 1:
            for first in range(apart % merged, count - apart, 2 * apart):
                near = range(first, min(first + apart, count - apart))
                whole = 2 * merged
                pairs += [(a, a + apart) for a in near if a // whole == (a + apart) // whole]
            apart //= 2
        merged *= 2
    return pairs


SEEN_PIXELS = 6_000
"""Of a picture, evenly spread; what moves covers less than half of them."""
LEAST_LEVEL = 0.1
"""Of the largest value of what stands still: darker pixels are mostly noise."""
STEADY = 0.01
"""Changes below this are none: what stands still tells them no better."""


class Brightness:
    """Compares pictures with what stands still, by the median ratio of their values.

    Cameras set their exposure anew while they film, and lamps flicker.

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
