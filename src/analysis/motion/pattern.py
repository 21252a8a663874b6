"""The marker pattern of a sphere, learned from its own frames, and its orientation in each.

Frame-to-frame matching (appendix B) loses count when markers come and go round the limb. Here
every frame is matched against one body pattern by rigid rotation, so a marker keeps its name for
the whole shot and the two views, which see different halves, share one pattern.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.errors import ShotRefusedError, counted
from analysis.motion.alignment import nearest_within, rotation_from_directions
from analysis.motion.rotation import rotation_matrix, rotation_vector

Floats = NDArray[np.float64]

MATCH_ANGLE = 0.22
"""Radians between a marker and its predicted place; markers stand at least twice as far apart."""
NEW_MARKER_ANGLE = 0.30
LEAST_COMMON = 3
LEAST_SIGHTINGS = 3
ROUNDS = 4
OUTLIER_ANGLE = 0.10


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
    left_out: dict[int, str] = {}
    frames, pattern, rotation = _first_pass(sightings, times_s, left_out)
    if len(frames) < 2:
        first = min(left_out, default=0)
        raise ShotRefusedError(
            "markers", f"sphere {sphere}: {left_out.get(first, 'no markers in any frame')}", first
        )
    matches: list[NDArray[np.intp]] = []
    for _ in range(ROUNDS):
        matches = [
            nearest_within(sightings[k].directions, pattern @ r.T, OUTLIER_ANGLE)
            for k, r in zip(frames, rotation, strict=True)
        ]
        pattern, index = average_pattern(sightings, frames, rotation, matches, len(pattern))
        matches = [np.where(m >= 0, index[m], -1) for m in matches]
        kept = [i for i, m in enumerate(matches) if _enough(m, frames[i], left_out)]
        frames, rotation = [frames[i] for i in kept], [rotation[i] for i in kept]
        matches = [matches[i] for i in kept]
        rotation = [_fit(sightings[k], pattern, m) for k, m in zip(frames, matches, strict=True)]
    return Orientations(
        frames=np.array(frames, dtype=np.intp),
        rotation=np.array(rotation).reshape(-1, 3, 3),
        covariance=orientation_covariances(sightings, frames, pattern, rotation, matches),
        pattern=pattern,
        matches=tuple(matches),
        left_out=left_out,
    )


def _first_pass(
    sightings: dict[int, Sightings], times_s: Floats, left_out: dict[int, str]
) -> tuple[list[int], Floats, list[Floats]]:
    """Follow the pattern forward in time, adding markers as they come round the limb.

    Two sightings may share a marker: each view may show it.
    """
    pattern = np.zeros((0, 3))
    frames: list[int] = []
    rotation: list[Floats] = []
    rate = np.zeros(3)
    for k, current in sorted(sightings.items()):
        if not frames:
            pattern = _distinct(current.directions)
            if _enough(np.arange(len(pattern)), k, left_out):
                frames, rotation = [k], [np.eye(3)]
            continue
        step = times_s[k] - times_s[frames[-1]]
        predicted = rotation_matrix(rate * step) @ rotation[-1]
        match = nearest_within(current.directions, pattern @ predicted.T, MATCH_ANGLE)
        for _ in range(3):
            if not _enough(match, k, left_out):
                break
            predicted = _fit(current, pattern, match)
            match = nearest_within(current.directions, pattern @ predicted.T, MATCH_ANGLE)
        if k in left_out:
            continue
        rate = rotation_vector(predicted @ rotation[-1].T) / step
        frames.append(k)
        rotation.append(predicted)
        near = nearest_within(current.directions, pattern @ predicted.T, NEW_MARKER_ANGLE)
        if (near < 0).any():
            strangers = _distinct(current.directions[near < 0])
            pattern = np.concatenate([pattern, strangers @ predicted])
    return frames, pattern, rotation


def _distinct(directions: Floats) -> Floats:
    """Return each marker once: both views may show it."""
    again = np.tril(_angles(directions, directions) < NEW_MARKER_ANGLE, k=-1)
    return np.asarray(directions[~again.any(axis=1)])


def _enough(match: NDArray[np.intp], frame: int, left_out: dict[int, str]) -> bool:
    common = len(set(match[match >= 0].tolist()))
    if common < LEAST_COMMON:
        left_out[frame] = (
            f"only {counted(common, 'marker')} in common with the frames before, "
            f"{LEAST_COMMON} are needed"
        )
    return common >= LEAST_COMMON


def _angles(first: Floats, second: Floats) -> Floats:
    chord = np.linalg.norm(first[:, None, :] - second[None, :, :], axis=2)
    return np.asarray(2.0 * np.arcsin(np.clip(chord / 2.0, 0.0, 1.0)))


def _fit(current: Sightings, pattern: Floats, match: NDArray[np.intp]) -> Floats:
    common = match >= 0
    weights = current.facing[common] ** 2
    return rotation_from_directions(pattern[match[common]], current.directions[common], weights)


def average_pattern(
    sightings: dict[int, Sightings],
    frames: list[int],
    rotation: list[Floats],
    matches: list[NDArray[np.intp]],
    size: int,
) -> tuple[Floats, NDArray[np.intp]]:
    """Average each marker in body axes; forget those seen in too few frames, or on the limb alone.

    Returns the pattern and, for each old index, its new one (-1: forgotten).
    """
    total, seen = np.zeros((size, 3)), np.zeros(size, dtype=np.intp)
    for k, r, match in zip(frames, rotation, matches, strict=True):
        common = match >= 0
        body = sightings[k].directions[common] @ r
        np.add.at(total, match[common], sightings[k].facing[common, None] ** 2 * body)
        seen[np.unique(match[common])] += 1
    # A marker that was never turned toward the camera has no weight, and so no place.
    kept = (seen >= min(LEAST_SIGHTINGS, len(frames))) & total.any(axis=1)
    index = np.where(kept, np.cumsum(kept) - 1, -1)
    pattern = total[kept]
    return pattern / np.linalg.norm(pattern, axis=1, keepdims=True), index


def orientation_covariances(
    sightings: dict[int, Sightings],
    frames: list[int],
    pattern: Floats,
    rotation: list[Floats],
    matches: list[NDArray[np.intp]],
) -> Floats:
    """Covariance of each orientation, with the scatter of the sightings themselves.

    A sighting of weight w turns the sphere about every axis across its direction d: information
    w (1 - d d') / sigma^2. sigma comes from all residuals of the shot.
    """
    squares, freedom = 0.0, -2.0 * len(pattern) - 3.0 * len(frames)
    information = np.zeros((len(frames), 3, 3))
    for i, (k, r, match) in enumerate(zip(frames, rotation, matches, strict=True)):
        common = match >= 0
        directions = sightings[k].directions[common]
        weights = sightings[k].facing[common] ** 2
        residual = directions - pattern[match[common]] @ r.T
        squares += float((weights[:, None] * residual**2).sum())
        freedom += 2.0 * common.sum()
        outer = directions[:, :, None] * directions[:, None, :]
        information[i] = (weights[:, None, None] * (np.eye(3) - outer)).sum(axis=0)
    variance = squares / max(freedom, 1.0)
    return np.asarray(variance * np.linalg.inv(information))
