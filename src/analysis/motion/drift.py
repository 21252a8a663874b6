"""Slow errors: what a marker does to an outline while it crosses the limb.

The error of an outline is not fresh noise in every frame. A marker on the limb shifts the fitted
circle for as long as it takes to turn past, so neighbouring frames err together and a straight
line follows the error instead of averaging it away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats

CENTRE_DRIFT_PER_SIGMA2 = 0.035
"""Pixels of slow error for each squared pixel of filter width.

The shift of a zero of the Laplacian of Gaussian by shading or a marker grows with sigma^2. Read off
the centre errors of eight shots of spheres with 16 markers: 0.05 px at sigma 1.2 and 0.14 px at 2
(docs/decisions/0004-slow-errors.md has other films).
"""
TURN_PER_CENTRE_ERROR = 1.5
"""An error of the centre tilts every marker's direction; both views together tilt by this much."""
SHORTEST_S, LONGEST_S = 1e-3, 1.0
WORST_LENGTH = 3.4
_SHORT = 1e-2
"""Of a correlation time: a line so short moves with the error as a whole."""


@dataclass(frozen=True, slots=True)
class Drift:
    """A slow error with exponential correlation in time.

    Attributes
    ----------
    sigma
        Its standard deviation, in the unit of the quantity.
    correlation_time_s
        Time in which the correlation falls to 1 / e.
    """

    sigma: float
    correlation_time_s: float

    def covariance(self, times_s: Floats) -> Floats:
        """Return its covariance between frames, shape (frames, frames)."""
        return self._after(np.abs(times_s[:, None] - times_s[None, :]))

    def between_neighbours(self, times_s: Floats) -> Floats:
        """Return its covariance between each frame and the next, shape (frames - 1,)."""
        return self._after(np.diff(times_s))

    def _after(self, gap_s: Floats) -> Floats:
        return np.asarray(self.sigma**2 * np.exp(-gap_s / self.correlation_time_s))


def line_variances(lengths: Floats) -> tuple[Floats, Floats]:
    """Return how wrong a straight line through a slow error of size 1 is, by least squares.

    Parameters
    ----------
    lengths
        Time over which the line was drawn, in correlation times.

    Returns
    -------
    Variance at the middle of that time, and of the slope, which are uncorrelated: over the squares
    of the error's size, and of its size over that time. The slope's is 2.45 at most, where the
    line is `WORST_LENGTH` correlation times long.
    """
    x = np.maximum(lengths, _SHORT)
    gone, once = np.exp(-x), -np.expm1(-x)
    middle = 2.0 * (x - once) / x**2
    # Of the integral of u v exp(-x |u - v|) over both from -1/2 to 1/2, times 12 squared.
    ends = 0.5 * once / x - (once - x * gone) / x**2
    slope = 144.0 * (1.0 / (6.0 * x) - 2.0 / x * (0.5 + 1.0 / x) * ends)
    return middle, slope


def centre_drift(filter_sigma_px: float, scale_px_per_m: float, correlation_time_s: float) -> Drift:
    """Return the slow error of a centre coordinate, m."""
    return Drift(CENTRE_DRIFT_PER_SIGMA2 * filter_sigma_px**2 / scale_px_per_m, correlation_time_s)


def turn_drift(filter_sigma_px: float, radius_px: float, correlation_time_s: float) -> Drift:
    """Return the slow error of an orientation about each axis, rad."""
    centre = CENTRE_DRIFT_PER_SIGMA2 * filter_sigma_px**2 / radius_px
    return Drift(TURN_PER_CENTRE_ERROR * centre, correlation_time_s)


def correlation_time(marker_angle: float, spin_rad_per_s: float) -> float:
    """Return the time in which a marker turns by its own width, s."""
    return float(correlation_times(2 * marker_angle, np.array(spin_rad_per_s)))


def correlation_times(memory_rad: float, spins_rad_per_s: Floats) -> Floats:
    """Return the times in which spheres turn by what their markers are wide, s.

    Errors of poses of rendered flights last about as long, whatever the renderer
    (docs/decisions/0035-slow-errors-by-campaign.md).
    """
    times = max(memory_rad, 0.05) / np.maximum(spins_rad_per_s, 1e-6)
    return np.asarray(np.clip(times, SHORTEST_S, LONGEST_S))
