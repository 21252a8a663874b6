"""A tape of moving discs, and a grabber on its playback that repeats fields and skips frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulators.ektapro.grabber import Grabber, Wrong

ROWS, COLUMNS = 96, 120


@dataclass(frozen=True)
class Digitised:
    """Frames of a grabber, their times in s, and the true number on each field of each."""

    frames: list[NDArray[np.uint8]]
    times_s: list[float]
    truth: list[tuple[int, int]]
    film_per_s: float


def tape(pictures: int, seed: int, moving: bool = True) -> list[NDArray[np.uint8]]:
    """Two discs that cross the field, with the sensor's noise of each picture."""
    random = np.random.default_rng(seed)
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    recorded = []
    for number in range(pictures):
        picture = np.full((ROWS, COLUMNS), 60.0)
        for column, speed in ((10.0, 1.5), (110.0, -1.5)):
            at = column + (speed * number if moving else 0.0)
            picture += 100 * np.clip(10.5 - np.hypot(rows - 50, columns - at), 0, 1)
        noisy = np.rint(picture + random.normal(0.0, 2.0, picture.shape))
        recorded.append(np.clip(noisy, 0, 255).astype(np.uint8))
    return recorded


def digitised(
    standard: str,
    *,
    phase: float = 0.3,
    runs_per_s: float = 30.0,
    frames: int = 24,
    wrong: Wrong | None = None,
    moving: bool = True,
    seed: int = 1,
) -> Digitised:
    """Digitise a tape that began to play `phase` pictures before the first field."""
    recorded = tape(2 * frames, seed, moving)

    def shown(time_s: float) -> tuple[int, NDArray[np.uint8]]:
        number = int(time_s * runs_per_s + phase)
        return number, recorded[number]

    grabber = Grabber(shown, standard, wrong, seed)
    taken = grabber.frames(frames)
    return Digitised(
        [pixels for _, _, pixels in taken],
        [time_s for time_s, _, _ in taken],
        [numbers for _, numbers, _ in taken],
        grabber.frames_per_s,
    )
