"""The marker pattern of a sphere, learned from its own frames, and its orientation in each.

Frame-to-frame matching (appendix B) loses count when markers come and go round the limb. Here
every frame is matched against one body pattern by rigid rotation, so a marker keeps its name for
the whole shot and the two views, which see different halves, share one pattern.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError, counted
from analysis.imaging.marker.markers import FilmMarkers
from analysis.motion.pattern_steps import LEAST_COMMON, Seen, learn_pattern


@dataclass(frozen=True, slots=True, eq=False)
class Orientations:
    """Orientation of a sphere by frame against one body frame.

    Attributes
    ----------
    frames
        Indices of the frames that have an orientation, shape (n,).
    rotation
        Body to rig axes, shape (n, 3, 3).
    covariance
        Of a small rotation vector in rig axes applied from the left, rad^2, shape (n, 3, 3).
    pattern
        Markers in body axes, unit vectors, shape (markers, 3).
    matches
        For each frame the index into `pattern` of each sighting, -1 where it has none.
    left_out
        For each frame without an orientation, why.
    """

    frames: NDArray[np.intp]
    rotation: Floats
    covariance: Floats
    pattern: Floats
    matches: tuple[NDArray[np.intp], ...]
    left_out: dict[int, str]

    @classmethod
    def none(cls) -> Self:
        """Return no orientations, of a sphere without markers."""
        empty = np.empty((0, 3, 3))
        return cls(np.empty(0, dtype=np.intp), empty, empty, np.empty((0, 3)), (), {})


def orient(seen: FilmMarkers, times_s: Floats, sphere: str) -> Orientations:
    """Learn the pattern of a sphere and its orientation in each frame.

    A frame that shares fewer than three markers with those before it is left out, with a note.

    Parameters
    ----------
    seen
        Markers of the sphere; their directions and facing are used.
    times_s
        Time of each frame of the shot, shape (frames,).
    sphere
        Its name, for the reason of a refusal.

    Raises
    ------
    ShotRefusedError
        Fewer than two frames have an orientation.
    """
    pattern, rotation, covariance, match, common = learn_pattern(
        sightings(seen), times_s[seen.frames]
    )
    few = np.flatnonzero(common < LEAST_COMMON)
    left_out = {int(seen.frames[n]): _few(int(common[n])) for n in few}
    used = np.flatnonzero(common >= LEAST_COMMON)
    if len(used) < 2:
        first = min(left_out, default=0)
        raise ShotRefusedError(
            "markers", f"sphere {sphere}: {left_out.get(first, 'no markers in any frame')}", first
        )
    spans = seen.spans()
    return Orientations(
        frames=seen.frames[used],
        rotation=rotation[used],
        covariance=covariance[used],
        pattern=pattern,
        matches=tuple(match[spans[f]] for f in used),
        left_out=left_out,
    )


def sightings(seen: FilmMarkers) -> Seen:
    """Return directions, facing and ends of a sphere's markers as the compiled steps take them."""
    return (
        np.ascontiguousarray(seen.every.directions),
        np.ascontiguousarray(seen.every.facing),
        seen.ends,
    )


def _few(common: int) -> str:
    return (
        f"only {counted(common, 'marker')} in common with the frames before, "
        f"{LEAST_COMMON} are needed"
    )
