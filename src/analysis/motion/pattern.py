"""The marker pattern of a sphere, learned from its own frames, and its orientation in each.

Frame-to-frame matching (appendix B) loses count when markers come and go round the limb. Here
every frame is matched against one body pattern by rigid rotation, so a marker keeps its name for
the whole shot and the two views, which see different halves, share one pattern.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.errors import ShotRefusedError, counted
from analysis.motion.pattern_steps import LEAST_COMMON, Seen, learn_pattern

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """Markers of one sphere in one frame, both views together.

    Attributes
    ----------
    directions
        Unit vectors in rig axes, shape (markers, 3).
    facing
        Cosine between each and its line of sight, shape (markers,).
    """

    directions: Floats
    facing: Floats


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


def orient(sightings: dict[int, Sightings], times_s: Floats, sphere: str) -> Orientations:
    """Learn the pattern of a sphere and its orientation in each frame.

    A frame that shares fewer than three markers with those before it is left out, and said so.

    Parameters
    ----------
    sightings
        By frame index.
    times_s
        Time of each frame of the shot, shape (frames,).
    sphere
        Its name, for the reason of a refusal.

    Raises
    ------
    ShotRefusedError
        Fewer than two frames have an orientation.
    """
    frames = sorted(sightings)
    seen = gathered([sightings[k] for k in frames])
    pattern, rotation, covariance, match, common = learn_pattern(seen, times_s[frames])
    left_out = {k: _few(int(n)) for k, n in zip(frames, common, strict=True) if n < LEAST_COMMON}
    used = np.flatnonzero(common >= LEAST_COMMON)
    if len(used) < 2:
        first = min(left_out, default=0)
        raise ShotRefusedError(
            "markers", f"sphere {sphere}: {left_out.get(first, 'no markers in any frame')}", first
        )
    matches = np.split(match, seen[2][:-1])
    return Orientations(
        frames=np.array(frames, dtype=np.intp)[used],
        rotation=rotation[used],
        covariance=covariance[used],
        pattern=pattern,
        matches=tuple(matches[f] for f in used),
        left_out=left_out,
    )


def gathered(sightings: Sequence[Sightings]) -> Seen:
    """Return the sightings of several frames one after the other."""
    ends = np.cumsum([len(own.facing) for own in sightings], dtype=np.intp)
    directions = np.concatenate([np.empty((0, 3)), *(own.directions for own in sightings)])
    return directions, np.concatenate([np.empty(0), *(own.facing for own in sightings)]), ends


def _few(common: int) -> str:
    return (
        f"only {counted(common, 'marker')} in common with the frames before, "
        f"{LEAST_COMMON} are needed"
    )
