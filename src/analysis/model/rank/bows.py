"""Flights that slow errors bend: powers of the time from the second on.

Places of a filmed ball share what its camera leaves open: a lens, a line of sight, an outline. Such
errors are squares and cubes of the height over the plate, which is a parabola of the time, and are
many times as large as the scatter from frame to frame. What changes as slowly says nothing of
whether frames were taken on time.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.poses import PoseData

POWERS = (2, 3, 4, 5, 6)
"""Of the time from the middle of a flight: the sixth is a cube of the height."""
SIDES, AXES = 2, 3


def bows(data: PoseData, slopes: Floats) -> Floats:
    """Return whitened bows of both flights along each axis, shape (S, 4, 3 F, K).

    K is 0 but for a ball on a plate whose slow errors are stated: flights of marked spheres have
    too few frames to tell a bow from a jitter.

    Parameters
    ----------
    slopes
        Of the prediction by the numbers of the flights, shape (S, 4, 3 F, 12): place and rate
        before the contact, then after it.
    """
    shots, blocks, length, _ = slopes.shape
    if not data.on_plate or data.slow.position_m <= 0.0:
        return np.zeros((shots, blocks, length, 0))
    times = np.repeat(data.times_s, AXES, axis=1)[:, None]
    axis = np.arange(length) % AXES
    found = []
    for side in range(SIDES):
        place = slopes[..., 6 * side : 6 * side + AXES]
        weight = np.sqrt((place**2).sum(axis=3))
        seen = weight > 0
        told = seen.any(axis=2, keepdims=True)
        first = np.where(told, np.where(seen, times, np.inf).min(axis=2, keepdims=True), 0.0)
        last = np.where(told, np.where(seen, times, -np.inf).max(axis=2, keepdims=True), 0.0)
        half = np.maximum(0.5 * (last - first), np.finfo(float).tiny)
        inside = np.where(seen, np.where(seen, times - 0.5 * (first + last), 0.0) / half, 0.0)
        found += [
            weight * inside**power * (axis == along) for power in POWERS for along in range(AXES)
        ]
    return np.stack(found, axis=3)
