"""Errors that the frames of a flight share: they look like motion, and no scatter betrays them.

What shading, a learned pattern or a filter does to an image changes slowly along a track. Such an
error e of each of the 48 numbers of the two flights, of known size, adds J Sigma J' to the unit
noise of the whitened residuals, J their slopes. Its inverse root is 1 - J C J', and acts in the
span of J alone: the scatter about free flight stays as it is. Sigma is that of straight lines
through errors that last while a sphere turns by what its markers are wide (`motion.drift`); where
its spin is not known, by as much as makes rates worst.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.poses import PoseData
from analysis.model.predict.sides import Flights
from analysis.model.predict.state import ShotStates
from analysis.motion.drift import WORST_LENGTH, correlation_times, line_variances

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


def slow_noise(data: PoseData, states: ShotStates, sides: Flights, slopes: Floats) -> Slow | None:
    """Return the whitening for the slow errors that the data state, None where they state none."""
    if not data.slow.stated:
        return None
    root = _roots(data, states, sides)
    gram = np.swapaxes(slopes, 2, 3) @ slopes
    values, vectors = np.linalg.eigh(np.swapaxes(root, 2, 3) @ gram @ root)
    values = np.maximum(values, 0.0)
    share = 1.0 - 1.0 / np.sqrt(1.0 + values)
    # For small values (1 - (1 + v)^(-1/2)) / v is a half.
    weight = np.where(values > _SMALL, share / np.maximum(values, _SMALL), 0.5)
    turned = root @ vectors
    return Slow(slopes, (turned * weight[..., None, :]) @ np.swapaxes(turned, 2, 3))


def _roots(data: PoseData, states: ShotStates, sides: Flights) -> Floats:
    """Return R with Sigma = R R' of the numbers of each sphere and kind, shape (S, 4, 12, 12).

    A line is wrong in its middle and in its slope, each for itself. The start of a flight is where
    its line is at first touch, into which both go.
    """
    shots = len(states.time_s)
    seen = np.asarray(data.measured.reshape(shots, -1, 2, 2, 3).any(axis=4))
    tau = (data.times_s - states.time_s[:, None])[:, :, None, None]
    sizes = np.array(data.slow.sizes)
    lasting_s = correlation_times(data.slow.memory_rad, np.linalg.norm(sides.spin, axis=3))
    still = ~np.asarray(seen[..., 1].any(axis=1))[:, :, None]
    roots = np.zeros((shots, 2, 2, 2, 2, 3, 2, 2, 3))
    for side, own in enumerate((seen & (tau <= 0), seen & (tau > 0))):
        first = np.where(own, tau, np.inf).min(axis=1)
        last = np.where(own, tau, -np.inf).max(axis=1)
        line = last > first
        span = np.where(line, last - first, 1.0)
        lengths = np.where(still, WORST_LENGTH, span / lasting_s[:, :, side, None])
        middle, slope = (np.sqrt(own) for own in line_variances(lengths))
        rate = np.where(line, slope / span, 0.0)
        late = (np.where(line, first, 0.0) + np.where(line, last, 0.0)) / 2
        for k in range(3):
            roots[..., side, 0, k, side, 0, k] = sizes[:, k] * np.where(line, middle, 1.0)
            roots[..., side, 0, k, side, 1, k] = -sizes[:, k] * late * rate
            roots[..., side, 1, k, side, 1, k] = sizes[:, k] * rate
    return roots.reshape(shots, 4, 12, 12)
