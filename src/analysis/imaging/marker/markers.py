"""The dark markers on a sphere: closed edges inside its outline, each an ellipse (thesis, 4.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.imaging.outlines import Outline, Place
from analysis.imaging.views import ViewGeometry


@dataclass(frozen=True, slots=True, eq=False)
class Markers:
    """Markers seen in one frame.

    Attributes
    ----------
    ellipses
        Their edges in the image, pixels, in the order of `shells.Ellipse`, shape (markers, 6).
    directions
        Unit vectors from the sphere's centre to each, rig axes, shape (markers, 3).
    facing
        Cosines of the angles between those and the line of sight: 1 at the disc's middle, shape
        (markers,).
    front
        Whether the front view shows each, or the top view, shape (markers,).
    """

    ellipses: Floats
    directions: Floats
    facing: Floats
    front: NDArray[np.bool_]

    def where(self, chosen: NDArray[np.bool_] | slice) -> Markers:
        """Return the chosen markers."""
        return Markers(
            self.ellipses[chosen], self.directions[chosen], self.facing[chosen], self.front[chosen]
        )

    def __len__(self) -> int:
        return len(self.facing)


@dataclass(frozen=True, slots=True, eq=False)
class FilmMarkers:
    """Markers of one sphere in all frames that have an outline of it.

    Attributes
    ----------
    frames
        Indices of those frames, increasing, shape (n,).
    ends
        Number of markers up to the end of each frame, shape (n,).
    every
        All of them, frame after frame.
    """

    frames: NDArray[np.intp]
    ends: NDArray[np.intp]
    every: Markers

    def get(self, frame: int) -> Markers | None:
        """Return the markers of a frame, None where it has no outline."""
        n = int(np.searchsorted(self.frames, frame))
        if n == len(self.frames) or self.frames[n] != frame:
            return None
        return self.every.where(self.spans()[n])

    def spans(self) -> list[slice]:
        """Return where the markers of each frame stand among all."""
        ends = self.ends.tolist()
        return [slice(a, b) for a, b in zip([0, *ends], ends, strict=False)]

    def frame_of_each(self) -> NDArray[np.intp]:
        """Return the index into `frames` of each marker, shape (markers,)."""
        return np.repeat(np.arange(len(self.frames)), np.diff(self.ends, prepend=0))

    def where(self, chosen: NDArray[np.bool_], every: Markers | None = None) -> FilmMarkers:
        """Return the chosen of all markers, or of others in their places; all frames stay."""
        kept = np.bincount(self.frame_of_each()[chosen], minlength=len(self.frames))
        return FilmMarkers(self.frames, np.cumsum(kept), (every or self.every).where(chosen))


def film_markers(seen: Mapping[int, Markers]) -> FilmMarkers:
    """Return the markers of a film from those of each frame."""
    frames = sorted(seen)
    ends = np.cumsum([len(seen[k]) for k in frames], dtype=np.intp)
    every = joined([seen[k] for k in frames])
    return FilmMarkers(np.array(frames, dtype=np.intp), ends, every)


@dataclass(frozen=True, slots=True)
class SeenDisc:
    """A sphere's disc in one view of a frame.

    Attributes
    ----------
    outline
        As fitted in this frame.
    radius_px
        As all frames together give it.
    geometry
        The view.
    """

    outline: Outline
    radius_px: float
    geometry: ViewGeometry

    def place(self) -> Place:
        """Return row, column and radius of the outline."""
        circle = self.outline.circle
        return circle.row, circle.column, circle.radius


def joined(parts: Sequence[Markers]) -> Markers:
    """Return the markers of all parts, in their order."""
    none = Markers(np.empty((0, 6)), np.empty((0, 3)), np.empty(0), np.empty(0, dtype=np.bool_))
    return Markers(
        *(np.concatenate([getattr(p, name) for p in (none, *parts)]) for name in Markers.__slots__)
    )
