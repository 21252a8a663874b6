"""A recorded sequence of frames with the time of each and what was lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class FrameSequence:
    """Frames of one shot, as they came from the source.

    Attributes
    ----------
    pixels
        Grey levels, shape (frames, rows, columns), 8 bit.
    times_s
        Recorded time of each frame, shape (frames,), strictly increasing, from the first frame
        of the recording or from the camera's own clock.
    sequence
        The source's own number of each frame, shape (frames,), strictly increasing.
    lost
        Sequence numbers that the source skipped. Never hidden: a shot with lost frames says so.
    source
        What the frames came from, for the manifest.
    """

    pixels: NDArray[np.uint8]
    times_s: NDArray[np.float64]
    sequence: NDArray[np.int64]
    lost: tuple[int, ...]
    source: str
