"""Interlaced frames: alternate rows are two fields, the second taken half a frame's time later."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles

Picture = NDArray[np.uint8] | NDArray[np.uint16]

Scan = Literal["progressive", "top-first", "bottom-first"]
"""How a frame was taken: at once, or as two fields, that of rows 0, 2, 4... first."""

SEEN_COLUMNS = 240
MOST_JUDGED = 40
"""Pairs of frames that tell which rows are the earlier."""


def parities(scan: Scan) -> tuple[int, ...]:
    """Return the first row, 0 or 1, of each field of a frame, in the order of time.

    A frame that was taken at once has no fields: nothing is returned.
    """
    orders: dict[Scan, tuple[int, ...]] = {"top-first": (0, 1), "bottom-first": (1, 0)}
    return orders.get(scan, ())


def field_times(frames_s: Floats, fields: int, frame_s: float) -> Floats:
    """Return the time of each field, s: those of a frame lie evenly within its own time.

    Parameters
    ----------
    frames_s
        Time of each frame, s, shape (frames,).
    fields
        Fields of a frame: 2, or 1 where it was taken at once.
    frame_s
        From one frame to the next, s; frames that are lost lengthen no field's time.
    """
    later = np.arange(fields) / fields * frame_s
    return np.asarray((frames_s[:, None] + later).ravel())


def filled(picture: Picture, parity: int) -> Picture:
    """Return a picture of the rows of one field; the others are the mean of their neighbours.

    `parity` is the field's first row; shape (rows, columns, channels) stays.
    """
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


def order(pictures: Iterable[Picture]) -> Scan:
    """Return which rows of interlaced pictures are the earlier, by what moves.

    Fields that follow one another are alike: from the later field of a frame to the earlier one of
    the next is a half step, the other way round it is three.
    """
    across = np.zeros(2)
    before: tuple[Singles, Singles] | None = None
    judged = 0
    for picture in pictures:
        if judged == MOST_JUDGED:
            continue  # A film that is read to its end is held in memory.
        even, odd = (grey(filled(picture, parity)) for parity in (0, 1))
        if before is not None:
            across += [
                float(np.abs(a - b).mean()) for a, b in ((before[1], even), (before[0], odd))
            ]
            judged += 1
        before = even, odd
    return "bottom-first" if across[1] < across[0] else "top-first"


def grey(picture: Picture) -> Singles:
    """Return some columns of a picture, of its green where it has colours: they tell as well."""
    step = max(1, picture.shape[1] // SEEN_COLUMNS)
    return np.asarray(picture[:, ::step, picture.shape[2] // 2], dtype=np.float32)
