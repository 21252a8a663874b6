"""The outlines of both spheres in both views, by frame."""

from __future__ import annotations

from dataclasses import dataclass, field

from analysis.imaging.outlines import Outline
from analysis.imaging.views import View


@dataclass(slots=True)
class Track:
    """The outlines of one sphere in one view, by frame."""

    view: View
    outlines: dict[int, Outline] = field(default_factory=dict)

    def centre(self, frame: int) -> tuple[float, float] | None:
        """Return the outline's centre in a frame, None where it was not found."""
        outline = self.outlines.get(frame)
        return None if outline is None else (outline.circle.row, outline.circle.column)


Spheres = tuple[dict[View, Track], dict[View, Track]]
"""Tracks of sphere a and of sphere b by view."""
