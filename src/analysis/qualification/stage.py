"""A sphere moved in quarters of a pixel: figures 4.1 and 4.2 of the thesis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey
from analysis.qualification.locating import WAYS, Way, follow_disc, locate

RADII_PX = (8.0, 40.0)
AXES = ("y", "x")
"""The thesis's names of rows and columns."""


@dataclass(frozen=True, slots=True, eq=False)
class StageErrors:
    """What one way of finding the centre made of one run.

    Attributes
    ----------
    way
        How the centre was found.
    direction
        "x" along the columns, "y" along the rows, "x-y" both.
    moved_px, measured_px
        Displacements (row, column) about their means, pixels, shape (positions, 2). The start's
        own error is common to all positions and is no error of a displacement.
    """

    way: Way
    direction: str
    moved_px: Floats
    measured_px: Floats

    @property
    def along(self) -> NDArray[np.intp]:
        """Coordinates that the stage moved."""
        return np.flatnonzero(np.ptp(self.moved_px, axis=0) > 0)

    @property
    def errors_px(self) -> Floats:
        """Errors of the coordinates that were moved, shape (positions, 1 or 2)."""
        return np.asarray((self.measured_px - self.moved_px)[:, self.along])

    @property
    def rms_px(self) -> float:
        """Root mean square of the errors; the mean took one freedom."""
        count = len(self.moved_px)
        return float(np.sqrt((self.errors_px**2).mean() * count / (count - 1)))

    @property
    def way_share(self) -> float:
        """Way that the places show over the way that is stated, by least squares."""
        stated, seen = self.moved_px[:, self.along], self.measured_px[:, self.along]
        return float((stated * seen).sum() / (stated**2).sum())

    @property
    def largest_px(self) -> float:
        """Largest error of any position."""
        return float(np.abs(self.errors_px).max())


def measure_stage(
    frames: Grey, moved_px: Floats, ways: tuple[Way, ...] = WAYS
) -> list[StageErrors]:
    """Measure one run of the stage by every way.

    Parameters
    ----------
    frames
        Shape (positions, rows, columns), one sphere in view.
    moved_px
        How far the stage stood from its start, (row, column), shape (positions, 2).

    Raises
    ------
    ShotRefusedError
        No disc is seen in some frame.
    """
    starts = follow_disc(frames, *RADII_PX)
    moved = moved_px - moved_px.mean(axis=0)
    direction = "-".join(AXES[k] for k in (1, 0) if np.ptp(moved_px[:, k]) > 0)
    results = []
    for way in ways:
        centres = np.array([place[:2] for place in locate(frames, starts, way)])
        measured = centres - centres.mean(axis=0)
        results.append(StageErrors(way, direction, moved, measured))
    return results
