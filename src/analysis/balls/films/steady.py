"""Films of a camera that moves: hands and wind shake it, and pictures are brought back."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import cast

import cv2
import numpy as np

from analysis import threads
from analysis.arrays import Floats
from analysis.balls.films.film import Film, Picture, spread_frames
from analysis.balls.films.moves import Reference
from analysis.errors import ShotRefusedError

SHAKEN_PX, SIGMAS = 0.15, 8.0
"""Shift of a picture that has moved, px and in its own errors."""
LEAST_BETTER, LEAST_SEEN, LEAST_FAR = 0.55, 0.6, 0.4
"""Of the parts, those that a move explains better than none; of the frames, those that are seen
again, and those that have moved."""
ENOUGH = 15
"""Frames that show whether a camera moves."""


class ShakenError(ShotRefusedError):
    """What stands still moves in the picture: the camera was not fixed."""


def refuse_shaken(samples: dict[int, Picture]) -> bool:
    """Raise `ShakenError` where what stands still has moved in most frames.

    Returns whether it would be seen: what stands still has edges over most of the picture.

    Parameters
    ----------
    samples
        Frames by their numbers.
    """
    frames = sorted(samples)[:: max(1, len(samples) // ENOUGH)]
    reference = Reference(samples[frames[len(frames) // 2]])
    if not reference.shows:
        return False
    moved = threads.each(lambda n: reference.moved(samples[n], np.zeros(4)), frames)
    found = dict(zip(frames, moved, strict=True))
    moves = {n: move for n, move in found.items() if move is not None and move.sure}
    if len(moves) < LEAST_SEEN * len(frames):
        return False
    # A first picture that differs from all others has not moved.
    middle = np.median([move.numbers for move in moves.values()], axis=0)
    shifts = {n: math.hypot(*(move.numbers - middle)[2:]) for n, move in moves.items()}
    far = [
        n
        for n, move in moves.items()
        if move.better > LEAST_BETTER and shifts[n] > max(SHAKEN_PX, SIGMAS * move.sigma_px)
    ]
    least = LEAST_FAR * len(frames)
    if len(far) <= least:
        return True
    if sum(reference.agreed(samples[n], moves[n]) for n in far) > least:
        worst = max(shifts, key=lambda number: shifts[number])
        raise ShakenError(
            "frames",
            f"the camera moves: what stands still lies {shifts[worst]:.1f} px elsewhere in frame "
            f"{worst}; put it on a stand",
            worst,
        )
    return False


class SteadyFilm(Film):
    """A film whose pictures are brought back to where the camera was in its middle frame.

    Turn, scale and shift of each picture are those of all that stands still, by the light of its
    edges.
    """

    def __init__(self, film: Film) -> None:
        super().__init__(film.path, replace(film.head, steady=True))
        self._film = film
        self._moves: list[Floats] = []

    def _read(self) -> Iterator[Picture]:
        if not self._moves:
            self._moves = self._followed()
        for picture, numbers in zip(self._film.pictures(), self._moves, strict=True):
            yield _brought_back(picture, numbers)

    def _followed(self) -> list[Floats]:
        """Return the move of each picture from the middle one: those of its neighbour if unseen."""
        head = self._film.head
        spread = spread_frames(head.frames, head.frame_bytes)
        number = spread[len(spread) // 2]
        reference = Reference(self._film.chosen([number])[number])
        moves = [np.zeros(4)]
        for picture in self._film.pictures():
            move = reference.moved(picture, moves[-1])
            moves.append(moves[-1] if move is None else move.numbers)
        return moves[1:]

    @property
    def note(self) -> str:
        """Say how far the pictures were moved."""
        shifts = [math.hypot(*numbers[2:]) for numbers in self._moves]
        worst = max(range(len(shifts)), key=lambda frame: shifts[frame], default=0)
        return (
            f"the camera moves: pictures were brought back by what stands still, furthest frame "
            f"{worst}, by {max(shifts, default=0.0):.1f} px"
        )


def _brought_back(picture: Picture, numbers: Floats) -> Picture:
    """Return a picture as it would be had the camera not moved.

    By `remap`: `warpAffine` puts pixels up to 0.1 px elsewhere.
    """
    scale, turn, right, down = numbers.tolist()
    rows, columns = picture.shape[:2]
    x = np.arange(columns, dtype=np.float32)[None] - 0.5 * (columns - 1)
    y = np.arange(rows, dtype=np.float32)[:, None] - 0.5 * (rows - 1)
    back = cv2.remap(
        picture,
        (1.0 + scale) * x + (right + 0.5 * (columns - 1) - turn * y),
        (1.0 + scale) * y + (down + 0.5 * (rows - 1)) + turn * x,
        cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return cast("Picture", back.reshape(picture.shape))
