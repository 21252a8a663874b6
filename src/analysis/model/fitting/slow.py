"""Errors that the frames of a flight share: they look like motion, and no scatter betrays them.

What shading, a learned pattern or a filter does to an image changes slowly along a track. Such an
error e of each of the 48 numbers of the two flights, of known size, adds J Sigma J' to the unit
noise of the whitened residuals, J their slopes. Its inverse root is 1 - J C J', and acts in the
span of J alone: the scatter about free flight stays as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.poses import PoseData
from analysis.model.predict.state import ShotStates

Floats = NDArray[np.float64]

RATE_FACTOR = 1.5
"""A rate is wrong by this many slow errors over the time the flight is seen: what a straight line
through an exponentially correlated error reaches at most, 1.52, where the flight lasts three
correlation times; 1.2 to 1.5 for one to ten."""
_SMALL = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Slow:
    """The whitening of slow errors, block by block.

    Attributes
    ----------
    slopes
        J, shape (S, 4, L, 12).
    inner
        C, shape (S, 4, 12, 12).
    """

    slopes: Floats
    inner: Floats

    def whiten(self, columns: Floats) -> Floats:
        """Whiten columns by spheres and kinds, shape (S, 4, L, K)."""
        pulled = self.inner @ (np.swapaxes(self.slopes, 2, 3) @ columns)
        return np.asarray(columns - self.slopes @ pulled)


def slow_noise(data: PoseData, states: ShotStates, slopes: Floats) -> Slow | None:
    """Return the whitening for the slow errors that the data state, None where they state none."""
    if not data.slow.stated:
        return None
    root = _sizes(data, states)
    gram = np.swapaxes(slopes, 2, 3) @ slopes
    values, vectors = np.linalg.eigh(root[..., :, None] * gram * root[..., None, :])
    values = np.maximum(values, 0.0)
    share = 1.0 - 1.0 / np.sqrt(1.0 + values)
    # For small values (1 - (1 + v)^(-1/2)) / v is a half.
    weight = np.where(values > _SMALL, share / np.maximum(values, _SMALL), 0.5)
    turned = root[..., :, None] * vectors
    return Slow(slopes, (turned * weight[..., None, :]) @ np.swapaxes(turned, 2, 3))


def _sizes(data: PoseData, states: ShotStates) -> Floats:
    """Return the size of the slow error of each of the 48 numbers, shape (S, 4, 12)."""
    seen = data.measured.any(axis=(2, 3))
    tau = data.times_s - states.time_s[:, None]
    sizes = np.zeros((len(tau), 2, 2, 2, 2, 3))
    for side, mask in enumerate((seen & (tau <= 0), seen & (tau > 0))):
        first = np.where(mask, tau, np.inf).min(axis=1)
        last = np.where(mask, tau, -np.inf).max(axis=1)
        span = np.where(last > first, last - first, np.inf)
        for kind, size in enumerate((data.slow.position_m, data.slow.rotation_rad)):
            sizes[:, :, kind, side, 0] = size
            sizes[:, :, kind, side, 1] = (RATE_FACTOR * size / span)[:, None, None]
    return sizes.reshape(len(tau), 4, 12)
