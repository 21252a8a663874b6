"""A frame grabber on the recorder's video output: two fields a frame, some repeated or skipped."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FIELDS_PER_S = {"ntsc": 60_000 / 1001, "pal": 50.0}
LINES = {"ntsc": (480, 640), "pal": (576, 720)}
NOISE_LEVELS = 0.7
"""Standard deviation of what the grabber's converter adds, grey levels: an assumption."""


@dataclass(frozen=True, slots=True)
class Wrong:
    """What goes wrong with a grabber: fields given again, frames left out.

    `repeated` are numbers of fields that show once more what the field before showed; `skipped`
    are numbers of frames that never come.
    """

    repeated: frozenset[int] = frozenset()
    skipped: frozenset[int] = frozenset()


class Grabber:
    """Digitises what the recorder shows, frame after frame of a television standard.

    Parameters
    ----------
    shown
        Returns the number and the pixels, shape (rows, columns), of the picture that the recorder
        shows at a time in seconds.
    standard
        "ntsc": 480 lines of 640 pixels, 59.94 fields/s; "pal": 576 of 720, 50 fields/s. The field
        of rows 0, 2, 4... comes first.
    wrong
        What goes wrong.
    seed
        Of the converter's noise.
    """

    def __init__(
        self,
        shown: Callable[[float], tuple[int, NDArray[np.uint8]]],
        standard: str,
        wrong: Wrong | None = None,
        seed: int = 0,
    ) -> None:
        self._shown, self._wrong = shown, wrong or Wrong()
        self._size, self._rate = LINES[standard], FIELDS_PER_S[standard]
        self._random = np.random.default_rng(seed)

    @property
    def frames_per_s(self) -> float:
        """Frames a second."""
        return self._rate / 2

    def frames(
        self, count: int, begin_s: float = 0.0
    ) -> list[tuple[float, tuple[int, int], NDArray[np.uint8]]]:
        """Return the frames that came of so many: time in s, numbers on both fields, pixels."""
        frames = []
        before: tuple[int, NDArray[np.uint8]] | None = None
        for frame in range(count):
            pair = []
            for field in (2 * frame, 2 * frame + 1):
                if before is None or field not in self._wrong.repeated:
                    before = self._shown(begin_s + field / self._rate)
                pair.append(before)
            if frame not in self._wrong.skipped:
                time_s = begin_s + 2 * frame / self._rate
                numbers = (pair[0][0], pair[1][0])
                frames.append((time_s, numbers, self._woven(pair[0][1], pair[1][1])))
        return frames

    def _woven(self, even: NDArray[np.uint8], odd: NDArray[np.uint8]) -> NDArray[np.uint8]:
        rows, columns = self._size
        frame = np.empty((rows, columns))
        for parity, picture in enumerate((even, odd)):
            lines = _at(np.arange(parity, rows, 2), rows, picture.shape[0])
            across = _at(np.arange(columns), columns, picture.shape[1])
            frame[parity::2] = _between(_between(picture.astype(float), lines).T, across).T
        frame += self._random.normal(0.0, NOISE_LEVELS, frame.shape)
        return np.clip(np.rint(frame), 0, 255).astype(np.uint8)


def _at(places: NDArray[np.int_], size: int, of: int) -> NDArray[np.float64]:
    """Return where centres of lines fall on a picture of another number of lines."""
    return np.clip((places + 0.5) * of / size - 0.5, 0, of - 1)


def _between(picture: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return lines of a picture at fractional places, by linear interpolation."""
    low = np.minimum(places.astype(int), picture.shape[0] - 2)
    share = (places - low)[:, None]
    return np.asarray((1 - share) * picture[low] + share * picture[low + 1])
