"""How dark the markers of a film are, before anything of it is rendered."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.marker.markers import FilmMarkers

Floats = NDArray[np.float64]

FACING = 0.7
AROUND, POINTS = 2.2, 12
"""Radii of a marker at which the surface beside it is looked at, and in how many places."""


def first_darkness(frames: NDArray[np.uint8], markers: tuple[FilmMarkers, ...]) -> float | None:
    """Return the share of the light that the middles of the markers lack, the median of all.

    None where no marker faces a view. Blur makes it less than it is on spheres of a few pixels.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).
    markers
        As seen on each sphere.
    """
    shares = np.concatenate([_shares(frames, own) for own in markers])
    return float(np.median(shares)) if shares.size else None


def _shares(frames: NDArray[np.uint8], markers: FilmMarkers) -> Floats:
    facing = markers.every.facing > FACING
    frame = markers.frames[markers.frame_of_each()[facing]]
    row, column, wide = markers.every.ellipses[facing, :3].T
    middle = [
        _grey(frames, frame, row + down, column + across)
        for down, across in product((-1, 0, 1), repeat=2)
    ]
    beside = [
        _grey(
            frames, frame, row + AROUND * wide * np.sin(turn), column + AROUND * wide * np.cos(turn)
        )
        for turn in np.arange(POINTS) * (2 * np.pi / POINTS)
    ]
    surface = np.median(beside, axis=0)
    return np.asarray(1.0 - np.mean(middle, axis=0) / np.maximum(surface, 1.0))


def _grey(
    frames: NDArray[np.uint8], frame: NDArray[np.intp], row: Floats, column: Floats
) -> Floats:
    """Return the grey levels of the nearest pixels, at the border those of the frame's rim."""
    last = frames.shape[1] - 1, frames.shape[2] - 1
    y = np.clip(np.rint(row), 0, last[0]).astype(np.intp)
    x = np.clip(np.rint(column), 0, last[1]).astype(np.intp)
    return frames[frame, y, x].astype(np.float64)
