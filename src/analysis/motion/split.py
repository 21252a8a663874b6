"""Which frames lie before the contact and which after."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import NoContactError
from analysis.motion.poses import Centres
from analysis.motion.velocity import DOWN

LEAST_FRAMES = 3
LEAST_IMPROVEMENT = 4.0
"""One straight line for all frames must fit this much worse than two: else nothing collided."""


def split_at_contact(a: Centres, b: Centres, times_s: Floats, gravity: float) -> int:
    """Return the index of the first frame after the contact.

    For every split, straight lines (gravity taken out) through both spheres before and after; the
    smallest weighted sum of squares wins.

    Raises
    ------
    NoContactError
        Too few frames with both spheres, or no kink in the tracks.
    """
    common = np.intersect1d(a.frames, b.frames)
    if common.size < 2 * LEAST_FRAMES:
        raise NoContactError(
            "contact",
            f"both spheres are measured in {common.size} frames; {2 * LEAST_FRAMES} are needed, "
            f"{LEAST_FRAMES} on each side of the contact",
        )
    pairs = [(c.position, c.sigma, np.isin(c.frames, common)) for c in (a, b)]
    times = times_s[common]
    drop = 0.5 * gravity * DOWN * (times[:, None] - times[0]) ** 2
    lines = [(position[chosen] - drop, sigma[chosen]) for position, sigma, chosen in pairs]
    splits = range(LEAST_FRAMES, common.size - LEAST_FRAMES + 1)
    before = np.arange(common.size) < np.array(splits)[:, None]
    parts = np.concatenate([before, ~before, np.ones((1, common.size), dtype=np.bool_)])
    a_cost, b_cost = (_costs(parts, times, p, s) for p, s in lines)
    cost = a_cost + b_cost
    costs, whole = cost[: len(splits)] + cost[len(splits) : -1], cost[-1]
    best = int(np.argmin(costs))
    freedom = 6 * common.size - 24
    excess = (whole - costs[best]) / 12 / max(costs[best] / max(freedom, 1), 1e-12)
    if excess < LEAST_IMPROVEMENT**2:
        raise NoContactError(
            "contact",
            "the tracks run straight through all frames: no contact is seen between frames "
            f"{common[0]} and {common[-1]}",
        )
    return int(common[splits[best]])


def _costs(parts: NDArray[np.bool_], times: Floats, position: Floats, sigma: Floats) -> Floats:
    """Return the weighted squares about the best straight line through each choice of frames.

    Parameters
    ----------
    parts
        Shape (choices, frames).
    position, sigma
        Shape (frames, 3); a coordinate with an infinite sigma was not measured.

    Returns
    -------
    Shape (choices,).
    """
    weight = parts[:, :, None] * sigma**-2.0
    seen = np.where(np.isfinite(sigma), position, 0.0)
    total = np.maximum(weight.sum(axis=1), np.finfo(np.float64).tiny)[:, None]
    tau = times[:, None] - (weight * times[:, None]).sum(axis=1, keepdims=True) / total
    off = seen - (weight * seen).sum(axis=1, keepdims=True) / total
    spread = (weight * tau**2).sum(axis=1, keepdims=True)
    slope = (weight * tau * off).sum(axis=1, keepdims=True) / np.where(spread > 0, spread, 1.0)
    return np.asarray((weight * (off - slope * tau) ** 2).sum(axis=(1, 2)))
