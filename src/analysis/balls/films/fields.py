"""Interlaced films: each picture holds two, taken one after the other, in alternate rows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.films.film import Film, Picture
from analysis.errors import ShotRefusedError
from analysis.imaging.fields import field_times, filled, grey, order, parities

CHANGED_SIGMAS = 6.0
LEAST_SHARE, LEAST_COMBED = 0.04, 40
"""Of the pixels that change: rows between two alike rows in so many of them are combs of fields."""
UNTIMED_S = 0.04
"""From one frame to the next where a film has one frame alone."""


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
    still = grey(ground)
    for number, picture in samples.items():
        changed, comb = _combed(grey(picture) - still, CHANGED_SIGMAS * noise)
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


def _combed(difference: Singles, level: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return where inner rows have changed, and where they differ from both like neighbours."""
    above, here, below = difference[:-2], difference[1:-1], difference[2:]
    changed = np.maximum(np.abs(here), np.maximum(np.abs(above), np.abs(below))) > level
    first, second = here - above, here - below
    least = np.minimum(np.abs(first), np.abs(second))
    comb = (first * second > 0) & (least > level) & (np.abs(above - below) < 0.5 * least)
    # The rim of what moves lies in some rows of a field; noise lies in single ones.
    both = comb[2:] & comb[:-2] & (first[2:] * first[:-2] > 0)
    kept = np.zeros_like(comb)
    kept[2:] |= both
    kept[:-2] |= both
    return changed, kept


class FieldsFilm(Film):
    """The fields of an interlaced film, one picture each, at twice its rate.

    Rows of the other field are the mean of their neighbours. Which field is the earlier is told by
    what moves: fields that follow one another are alike.
    """

    def __init__(self, film: Film) -> None:
        head = film.head
        self._film = film
        self._parities = parities(order(film.pictures()))
        rows = ("even", "odd")[self._parities[0]]
        note = (
            f"the film is interlaced: its {head.frames} pictures are {2 * head.frames} fields, "
            f"{rows} rows first, which are measured each at its own time; frames count fields"
        )
        super().__init__(
            film.path,
            replace(
                head,
                frames=2 * head.frames,
                per_frame=2.0 * head.per_frame,
                times_s=None if head.times_s is None else _times(head.times_s),
                rate_hz=None if head.rate_hz is None else 2 * head.rate_hz,
                notes=(*head.notes, note),
            ),
        )

    def _read(self) -> Iterator[Picture]:
        for picture in self._film.pictures():
            for parity in self._parities:
                yield filled(picture, parity)


def _times(times_s: Floats) -> Floats:
    """Return times of fields, s."""
    frame_s = float(np.median(np.diff(times_s))) if len(times_s) > 1 else UNTIMED_S
    return field_times(times_s, 2, frame_s)
