"""The outlines of both spheres in both views, by frame."""

from __future__ import annotations

from dataclasses import dataclass, field

from analysis.imaging.outlines import Outline
from analysis.imaging.views import View

MOST_MISSES = 3


@dataclass(slots=True)
class Track:
    """The outlines of one sphere in one view, by frame."""

    view: View
    outlines: dict[int, Outline] = field(default_factory=dict)

    def centre(self, frame: int) -> tuple[float, float] | None:
        """Return the outline's centre in a frame, None where it was not found."""
        outline = self.outlines.get(frame)
        return None if outline is None else (outline.circle.row, outline.circle.column)

    def predict(self, frame: int, direction: int) -> tuple[float, float] | None:
        """Extrapolate the centre linearly from the two nearest frames already followed.

        None where the last one lies more than a few frames back: the sphere is lost.
        """
        nearest = self._nearest(frame, direction)
        if not nearest or abs(nearest[0] - frame) > MOST_MISSES + 1:
            return None
        last = self.outlines[nearest[0]].circle
        if len(nearest) < 2:
            return last.row, last.column
        before = self.outlines[nearest[1]].circle
        share = (frame - nearest[0]) / (nearest[0] - nearest[1])
        return (
            last.row + share * (last.row - before.row),
            last.column + share * (last.column - before.column),
        )

    def _nearest(self, frame: int, direction: int) -> list[int]:
        """Return the two nearest frames that come before one in the direction of following."""
        found: list[int] = []
        first, last = min(self.outlines, default=0), max(self.outlines, default=-1)
        k = min(frame - 1, last) if direction > 0 else max(frame + 1, first)
        while len(found) < 2 and first <= k <= last:
            if k in self.outlines:
                found.append(k)
            k -= direction
        return found


Spheres = tuple[dict[View, Track], dict[View, Track]]
"""Tracks of sphere a and of sphere b by view."""


def frames_of(spheres: Spheres) -> list[int]:
    """Return the frames in which any disc was found, in order."""
    found: set[int] = set()
    for sphere in spheres:
        for track in sphere.values():
            found.update(track.outlines)
    return sorted(found)
