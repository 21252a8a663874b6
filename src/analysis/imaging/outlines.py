"""The outline of a sphere: a circle through the edge points that belong to its limb."""

from __future__ import annotations

from dataclasses import dataclass

from analysis.arrays import Floats
from analysis.imaging.shells import Circle

Place = tuple[float, float, float]
"""Row, column and radius of a disc, pixels."""


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A fitted outline.

    Attributes
    ----------
    circle
        Centre and radius in pixels with their covariance.
    coverage
        Share of 10 degree sectors of the rim that hold accepted edge points, 0 to 1.
    points
        Accepted edge points (row, column) in pixels, shape (points, 2).
    """

    circle: Circle
    coverage: float
    points: Floats
