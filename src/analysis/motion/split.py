"""Which frames lie before the contact and which after."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.errors import ShotRefusedError
from analysis.motion.poses import Centres
from analysis.motion.velocity import DOWN

Floats = NDArray[np.float64]

LEAST_FRAMES = 3
LEAST_IMPROVEMENT = 4.0
"""One straight line for all frames must fit this much worse than two: else nothing collided."""


def split_at_contact(a: Centres, b: Centres, times_s: Floats, gravity: float) -> int:
    """Return the index of the first frame after the contact.

    For every split, straight lines (gravity taken out) through both spheres before and after; the
    smallest weighted sum of squares wins.

    Raises
    ------
    ShotRefusedError
        Too few frames with both spheres, or no kink in the tracks.
    """
    common = np.intersect1d(a.frames, b.frames)
    if common.size < 2 * LEAST_FRAMES:
        raise ShotRefusedError(
            "contact",
            f"both spheres are measured in {common.size} frames; {2 * LEAST_FRAMES} are needed, "
            f"{LEAST_FRAMES} on each side of the contact",
        )
    pairs = [(c.position, c.sigma, np.isin(c.frames, common)) for c in (a, b)]
    times = times_s[common]
    drop = 0.5 * gravity * DOWN * (times[:, None] - times[0]) ** 2
    lines = [(position[chosen] - drop, sigma[chosen]) for position, sigma, chosen in pairs]
    splits = range(LEAST_FRAMES, common.size - LEAST_FRAMES + 1)
    costs = [
        sum(_cost(times[part], p[part], s[part]) for p, s in lines for part in _sides(split))
        for split in splits
    ]
    best = int(np.argmin(costs))
    whole = sum(_cost(times, p, s) for p, s in lines)
    freedom = 6 * common.size - 24
    excess = (whole - costs[best]) / 12 / max(costs[best] / max(freedom, 1), 1e-12)
    if excess < LEAST_IMPROVEMENT**2:
        raise ShotRefusedError(
            "contact",
            "the tracks run straight through all frames: no contact is seen between frames "
            f"{common[0]} and {common[-1]}",
        )
    return int(common[splits[best]])


def _sides(split: int) -> tuple[slice, slice]:
    return slice(None, split), slice(split, None)


def _cost(times: Floats, position: Floats, sigma: Floats) -> float:
    design = np.stack([np.ones_like(times), times - times.mean()], 1)
    cost = 0.0
    for axis in range(3):
        seen = np.isfinite(sigma[:, axis])
        weight = 1.0 / sigma[seen, axis]
        white = weight * position[seen, axis]
        own = weight[:, None] * design[seen]
        fit, *_ = np.linalg.lstsq(own, white, rcond=None)
        cost += float(((white - own @ fit) ** 2).sum())
    return cost
