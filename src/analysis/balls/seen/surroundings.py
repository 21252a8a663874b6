"""What a search keeps of a film that is too large for memory: the pictures about all sightings.

To decode a film of 1920 x 1080 pixels once more takes longer than all else that is done with it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.films.film import HELD_BYTES, Picture
from analysis.balls.seen.quarter_turns import Shape, picture_turned

Box = tuple[int, int, int, int]
"""First row, first column, and those after the last."""

REACH_RADII, REACH_PX = 4.5, 8.0
"""About a sighting: the ball, what its fit needs of the ground, and a smear of six radii."""


@dataclass(slots=True, eq=False)
class Surroundings:
    """Parts of pictures about sightings.

    Attributes
    ----------
    samples
        Whole pictures of some frames by their numbers.
    reach_px
        From a sighting to the border of what is kept.
    parts
        Of each frame, the box and the pixels of each sighting.
    room
        Bytes that may still be kept; negative where some sightings are not.
    turns, shape
        Quarter turns by which parts are turned when they are cut, and the shape of the pictures
        before.
    """

    samples: dict[int, Picture]
    reach_px: int
    parts: dict[int, list[tuple[Box, Picture]]]
    room: float
    turns: int = 0
    shape: Shape = (0, 0)

    @classmethod
    def new(cls, radius_px: float, samples: dict[int, Picture]) -> Surroundings:
        """Return what is kept of a ball of this radius before a film is read."""
        return cls(samples, round(REACH_RADII * radius_px + REACH_PX), {}, HELD_BYTES)

    def keep(self, frame: int, picture: Picture, places: Floats) -> None:
        """Keep a picture's parts about places (row, column, ...), shape (N, 3)."""
        rows, columns = picture.shape[:2]
        for row, column in np.rint(places[:, :2]).astype(int).tolist():
            if self.room < 0:
                return
            box = (
                max(0, row - self.reach_px),
                max(0, column - self.reach_px),
                min(rows, row + self.reach_px + 1),
                min(columns, column + self.reach_px + 1),
            )
            part = picture[box[0] : box[2], box[1] : box[3]].copy()
            self.room -= part.nbytes
            self.parts.setdefault(frame, []).append((box, part))

    def cut(self, frame: int, box: Box) -> Picture | None:
        """Return a box of a frame; None where it was not kept whole."""
        box = self._before(box)
        for (top, left, bottom, right), part in self.parts.get(frame, []):
            if top <= box[0] and left <= box[1] and box[2] <= bottom and box[3] <= right:
                cut = part[box[0] - top : box[2] - top, box[1] - left : box[3] - left]
                return picture_turned(cut, self.turns)
        return None

    def turned(self, samples: dict[int, Picture], shape: Shape, turns: int) -> Surroundings:
        """Return what is kept, for pictures that are turned; `samples` are turned already."""
        return replace(self, samples=samples, shape=shape, turns=turns)

    def _before(self, box: Box) -> Box:
        """Return a box of turned pictures where it lies before they are turned."""
        top, left, bottom, right = box
        rows, columns = self.shape
        for left_over in range(self.turns, 0, -1):
            # By the last of these quarter turns a row became a column, counted as it was.
            high = columns if left_over % 2 else rows
            top, left, bottom, right = left, high - bottom, right, high - top
        return top, left, bottom, right
