"""Part of a film: some frames, a part of the picture, or the picture turned upright."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from analysis.balls.films.film import Film, Picture
from analysis.errors import InputError


@dataclass(frozen=True, slots=True)
class Cut:
    """What of a film is looked at.

    Attributes
    ----------
    first, last
        Half-open range of frames; None: to the end.
    window
        Column, row, width and height of the part of the picture; None: all of it.
    """

    first: int = 0
    last: int | None = None
    window: tuple[int, int, int, int] | None = None


class PartOfFilm(Film):
    """A cut of a film, whose pixels outside are never looked at, turned by quarter turns.

    Raises
    ------
    InputError
        The cut holds no frames, or lies outside the picture.
    """

    def __init__(self, film: Film, cut: Cut, quarter_turns: int = 0) -> None:
        head = film.head
        last = head.frames if cut.last is None else cut.last
        if not 0 <= cut.first < last <= head.frames:
            raise InputError(
                film.path, f"frames {cut.first}:{last} are not within its {head.frames} frames"
            )
        left, top, width, height = cut.window or (0, 0, head.width, head.height)
        inside = left + width <= head.width and top + height <= head.height
        if not (left >= 0 <= top and width >= 8 <= height and inside):
            raise InputError(
                film.path,
                f"the part {left},{top},{width},{height} (column, row, width, height) is not "
                f"within its {head.width} x {head.height} pixels, or is smaller than 8 x 8",
            )
        self._film, self._first, self._last = film, cut.first, last
        self._corner, self._size, self._turns = (top, left), (height, width), quarter_turns % 4
        across = self._turns % 2 == 1
        rows, columns = head.whole
        turned: dict[str, str] = {"rows": "columns", "columns": "rows"} if across else {}
        times = head.times_s
        super().__init__(
            film.path,
            replace(
                head,
                frames=last - cut.first,
                height=width if across else height,
                width=height if across else width,
                times_s=None if times is None else times[cut.first : last] - times[cut.first],
                readout=cast("object", turned.get(head.readout, head.readout)),  # type: ignore[arg-type]
                whole_px=(columns, rows) if across else (rows, columns),
                principal_px=self._turned(head.principal),
            ),
        )

    def _turned(self, place: tuple[float, float]) -> tuple[float, float]:
        """Return row and column here of a place of the whole film's pictures."""
        row, column = place[0] - self._corner[0], place[1] - self._corner[1]
        height, width = self._size
        for _ in range(self._turns):
            row, column = width - 1 - column, row
            height, width = width, height
        return row, column

    def _read(self) -> Iterator[Picture]:
        (top, left), (height, width) = self._corner, self._size
        for number, picture in enumerate(self._film.pictures()):
            if number >= self._last:
                return
            if number >= self._first:
                part = picture[top : top + height, left : left + width]
                yield cast("Picture", np.ascontiguousarray(np.rot90(part, self._turns)))
