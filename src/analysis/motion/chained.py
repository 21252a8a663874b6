"""Orientation from frame to frame, as the thesis has it: match the markers, turn by turn.

Every step adds its error to all that follow, and only the front view takes part. Kept for
comparison with `pattern`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError, counted
from analysis.imaging.marker.markers import FilmMarkers, Markers
from analysis.motion.alignment import rotation_from_directions
from analysis.motion.pattern import Orientations, sightings
from analysis.motion.pattern_steps import LEAST_COMMON, average_pattern, orientation_covariances
from analysis.motion.proximal import match_markers

REACH = 0.4
"""Markers move by less than this share of the radius in one frame."""


def orient_by_steps(seen: FilmMarkers, radius_px: float, sphere: str) -> Orientations:
    """Turn the sphere from frame to frame by the markers that two frames share.

    Parameters
    ----------
    seen
        Markers of one sphere; those of the front view are used.
    radius_px
        Radius of the sphere in the front view.
    sphere
        Its name, for the reason of a refusal.

    Raises
    ------
    ShotRefusedError
        Two neighbouring frames share fewer than three markers.
    """
    front = seen.where(seen.every.front)
    frames = front.frames.tolist()
    found = [front.every.where(own) for own in front.spans()]
    # Place of each against the disc's centre, pixels (row, column).
    points = [radius_px * markers.directions[:, :2] for markers in found]
    names = match_markers(points, REACH * radius_px)
    rotation = [np.eye(3)]
    for i in range(1, len(frames)):
        step = _step(found[i - 1], names[i - 1], found[i], names[i])
        if step is None:
            common = np.intersect1d(names[i - 1], names[i]).size
            raise ShotRefusedError(
                "markers",
                f"only {counted(common, 'marker')} of sphere {sphere} in common with "
                f"frame {frames[i - 1]}, {LEAST_COMMON} are needed",
                frames[i],
            )
        rotation.append(step @ rotation[-1])
    size = 1 + max((int(n.max()) for n in names if n.size), default=-1)
    every, match = sightings(front), np.concatenate(names)
    turns, used = np.array(rotation), np.ones(len(frames), dtype=np.bool_)
    pattern = average_pattern(every, turns, used, match, size)
    return Orientations(
        frames=front.frames,
        rotation=turns,
        covariance=orientation_covariances(every, turns, used, match, pattern),
        pattern=pattern,
        matches=tuple(match[own] for own in front.spans()),
        left_out={},
    )


def _step(
    before: Markers, names_before: NDArray[np.intp], now: Markers, names: NDArray[np.intp]
) -> Floats | None:
    common, first, second = np.intersect1d(names_before, names, return_indices=True)
    if common.size < LEAST_COMMON:
        return None
    weights = now.facing[second] ** 2
    return rotation_from_directions(before.directions[first], now.directions[second], weights)
