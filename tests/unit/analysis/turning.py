"""Synthetic markers on a turning sphere, as the two views would show them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analysis.imaging.marker.markers import Markers, film_markers
from analysis.motion.pattern import Orientations, orient

Floats = NDArray[np.float64]

CAMERA, UP = np.array([0.0, 0.0, 1.0]), np.array([-1.0, 0.0, 0.0])
LEAST_FACING = 0.5
"""Markers more than 60 degrees from the line of sight are too foreshortened."""


def body_markers(number: int = 16, separation: float = 0.55, seed: int = 4) -> Floats:
    """Return directions at least `separation` radians apart, shape (number, 3)."""
    rng = np.random.default_rng(seed)
    chosen: list[Floats] = []
    while len(chosen) < number:
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        if all(direction @ other < np.cos(separation) for other in chosen):
            chosen.append(direction)
    return np.array(chosen)


def sighted(directions: Floats, facing: Floats) -> Markers:
    """Return markers of which only the direction and the facing matter."""
    return Markers(
        np.zeros((len(facing), 6)), directions, facing, np.ones(len(facing), dtype=np.bool_)
    )


def sight(
    body: Floats, turn: Rotation, rng: np.random.Generator, noise: float = 0.0
) -> tuple[Markers, NDArray[np.intp]]:
    """Return what both views see of the markers, in any order, and which marker each one is."""
    directions, facing, names = [], [], []
    for eye in (CAMERA, UP):
        turned = turn.apply(body)
        towards = turned @ eye
        seen = np.flatnonzero(towards > LEAST_FACING)
        shown = turned[seen] + noise * rng.normal(size=(seen.size, 3))
        directions.append(shown / np.linalg.norm(shown, axis=1, keepdims=True))
        facing.append(towards[seen])
        names.append(seen)
    order = rng.permutation(sum(len(n) for n in names))
    return (
        sighted(np.concatenate(directions)[order], np.concatenate(facing)[order]),
        np.concatenate(names)[order],
    )


def oriented(seen: dict[int, Markers], times_s: Floats, sphere: str) -> Orientations:
    """Learn orientations from the markers of each frame."""
    return orient(film_markers(seen), times_s, sphere)
