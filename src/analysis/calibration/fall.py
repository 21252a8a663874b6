"""How spheres fall in the images: roll and tilt of the camera against gravity.

A camera that rolls sees spheres fall to one side (`camera-roll`), one that tilts, or gravity out of
plumb, toward or away from it (`gravity-direction`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.errors import ShotRefusedError
from analysis.motion.poses import Centres
from analysis.motion.split import split_at_contact

Floats = NDArray[np.float64]

LEAST_FRAMES = 5
"""On one side of the contact: four determine nothing beyond a parabola and one residual."""


@dataclass(frozen=True, slots=True, eq=False)
class Fall:
    """Acceleration along Y and Z with their variances, m/s^2, shape (2,)."""

    acceleration: Floats
    variance: Floats


def falls_of(centres: tuple[Centres, Centres], times_s: Floats, gravity: float) -> list[Fall]:
    """Return the falls of both spheres before and after the contact of one shot.

    The frames next to the contact, which may show both motions, are left out. Without a contact
    there are none.
    """
    try:
        split = split_at_contact(*centres, times_s, gravity)
    except ShotRefusedError:
        return []
    sides = [(0, split - 1), (split + 1, len(times_s))]
    falls = [_fall(own, times_s, side) for own in centres for side in sides]
    return [fall for fall in falls if fall is not None]


def _fall(own: Centres, times_s: Floats, side: tuple[int, int]) -> Fall | None:
    chosen = (own.frames >= side[0]) & (own.frames < side[1])
    chosen &= np.isfinite(own.position).all(axis=1) & np.isfinite(own.sigma).all(axis=1)
    if chosen.sum() < LEAST_FRAMES:
        return None
    times = times_s[own.frames[chosen]]
    times = times - times.mean()
    design = np.stack([np.ones(len(times)), times, times**2 / 2], axis=1)
    values, variances = [], []
    for axis in (1, 2):
        sigma = own.sigma[chosen, axis]
        inverse = np.linalg.inv(design.T @ (design / sigma[:, None] ** 2))
        values.append((inverse @ design.T @ (own.position[chosen, axis] / sigma**2))[2])
        variances.append(inverse[2, 2])
    return Fall(np.array(values), np.array(variances))


def sideways(falls: Sequence[Fall], gravity: float) -> tuple[Floats, Floats]:
    """Return the angles of the fall from X toward Y and Z, rad, and their errors, shape (2,).

    Errors are enlarged to the scatter between the falls. Without falls: 0 with infinite errors.
    """
    if not falls:
        return np.zeros(2), np.full(2, np.inf)
    values = np.stack([fall.acceleration for fall in falls])
    weights = 1.0 / np.stack([fall.variance for fall in falls])
    mean = (weights * values).sum(axis=0) / weights.sum(axis=0)
    chi2 = (weights * (values - mean) ** 2).sum(axis=0) / max(len(falls) - 1, 1)
    sigma = np.sqrt(np.maximum(chi2, 1.0) / weights.sum(axis=0))
    return mean / gravity, sigma / gravity
