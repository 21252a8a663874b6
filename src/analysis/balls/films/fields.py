"""Interlaced films: each picture holds two, taken one after the other, in alternate rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.balls.films.film import Film, Floats, Picture
from analysis.errors import ShotRefusedError

Singles = NDArray[np.float32]

CHANGED_SIGMAS = 6.0
LEAST_SHARE, LEAST_COMBED = 0.04, 40
"""Of the pixels that change: rows between two alike rows in so many of them are combs of fields."""
SEEN_COLUMNS = 240
MOST_JUDGED = 40
"""Pairs of frames that tell which rows are the earlier."""


class InterlacedError(ShotRefusedError):
    """What moves in a film is combed: rows of two times alternate."""


def refuse_combed(samples: dict[int, Picture], ground: Picture, noise: float) -> None:
    """Raise `InterlacedError` where what moves shows in every second row alone.

    Parameters
    ----------
    samples
        Frames by their numbers.
    ground
        What stands still.
    noise
        Standard deviation of a pixel, grey levels.
    """
    moving = combed = most = 0
    worst = 0, 0
    still = _grey(ground)
    for number, picture in samples.items():
        changed, comb = _combed(_grey(picture) - still, CHANGED_SIGMAS * noise)
        moving += int(changed.sum())
        own = int(comb.sum())
        combed += own
        if own > most:
            rows, _ = np.nonzero(comb)
            most, worst = own, (number, int(np.median(rows)) + 1)
    if combed > max(LEAST_COMBED, LEAST_SHARE * moving):
        raise InterlacedError(
            "frames",
            f"interlaced: what moves is seen in every second row alone, most in frame {worst[0]} "
            f"about row {worst[1]} ({combed} of {moving} pixels that change); save it as one "
            "picture for each field",
            worst[0],
        )


def _grey(picture: Picture) -> Singles:
    """Return some columns of a picture, of its green where it has colours: they tell as well."""
    step = max(1, picture.shape[1] // SEEN_COLUMNS)
    return np.asarray(picture[:, ::step, picture.shape[2] // 2], dtype=np.float32)


def _combed(difference: Singles, level: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return where inner rows have changed, and where they differ from both like neighbours."""
    above, here, below = difference[:-2], difference[1:-1], difference[2:]
    changed = np.maximum(np.abs(here), np.maximum(np.abs(above), np.abs(below))) > level
    first, second = here - above, here - below
    least = np.minimum(np.abs(first), np.abs(second))
    comb = (first * second > 0) & (least > level) & (np.abs(above - below) < 0.5 * least)
    return changed, comb


class FieldsFilm(Film):
    """The fields of an interlaced film, one picture each, at twice its rate.

    Rows of the other field are the mean of their neighbours. Which field is the earlier is told by
    what moves: fields that follow one another are alike.
    """

    def __init__(self, film: Film) -> None:
        head = film.head
        self._film = film
        self._first = _earlier(film.pictures())
        rows = ("even", "odd")[self._first]
        note = (
            f"the film is interlaced: its {head.frames} pictures are {2 * head.frames} fields, "
            f"{rows} rows first, which are measured each at its own time; frames count fields"
        )
        super().__init__(
            film.path,
            replace(
                head,
                frames=2 * head.frames,
                times_s=None if head.times_s is None else _times(head.times_s),
                rate_hz=None if head.rate_hz is None else 2 * head.rate_hz,
                notes=(*head.notes, note),
            ),
        )

    def _read(self) -> Iterator[Picture]:
        for picture in self._film.pictures():
            yield field(picture, self._first)
            yield field(picture, 1 - self._first)


def field(picture: Picture, parity: int) -> Picture:
    """Return a picture of the even (0) or odd (1) rows; the others are filled in between them."""
    whole = picture.copy()
    other = 1 - parity
    known = picture[parity::2]
    mean = ((known[:-1].astype(np.float32) + known[1:]) / 2 + 0.5).astype(picture.dtype)
    inner = whole[2 - other : 2 - other + 2 * len(mean) : 2]
    inner[:] = mean[: len(inner)]
    if other == 0:
        whole[0] = picture[1]
    if (len(picture) - 1) % 2 == other:
        whole[-1] = picture[-2]
    return whole


def _times(times_s: Floats) -> Floats:
    """Return times of fields: the second of each frame lies half-way to the next frame."""
    steps = np.diff(times_s, append=2 * times_s[-1] - times_s[-2]) if len(times_s) > 1 else [0.04]
    return np.asarray(np.stack([times_s, times_s + 0.5 * np.asarray(steps)], axis=1).ravel())


def _earlier(pictures: Iterable[Picture]) -> int:
    """Return which rows are the earlier: 0, the even ones, or 1."""
    across = np.zeros(2)
    before: tuple[Singles, Singles] | None = None
    judged = 0
    for picture in pictures:
        even, odd = (_grey(field(picture, parity)) for parity in (0, 1))
        if before is not None and judged < MOST_JUDGED:
            # From the later field of a frame to the earlier one of the next is a half step; the
            # other way round it is three.
            steps = [float(np.abs(a - b).mean()) for a, b in ((before[1], even), (before[0], odd))]
            across += steps
            judged += 1
        before = even, odd
    return int(across[1] < across[0])
