"""The outlines of both spheres in both views, by frame."""

from __future__ import annotations

from dataclasses import dataclass, field

from analysis.imaging.outlines import Outline, Place
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
        followed = [k for k in self.outlines if (k - frame) * direction < 0]
        nearest = sorted(followed, key=lambda k: abs(k - frame))[:2]
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


Spheres = tuple[dict[View, Track], dict[View, Track]]
"""Tracks of sphere a and of sphere b by view."""


def other_discs(spheres: Spheres, frame: int, own: Outline) -> list[Place]:
    """Return where all discs of a frame but one stand."""
    return [
        (outline.circle.row, outline.circle.column, outline.circle.radius)
        for sphere in spheres
        for track in sphere.values()
        if (outline := track.outlines.get(frame)) is not None and outline is not own
    ]
