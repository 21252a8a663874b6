"""Slow errors: what a marker does to an outline while it crosses the limb.

The error of an outline is not fresh noise in every frame. A marker on the limb shifts the fitted
circle for as long as it takes to turn past, so neighbouring frames err together and a straight
line follows the error instead of averaging it away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CENTRE_DRIFT_PER_SIGMA2 = 0.035
"""Pixels of slow error for each squared pixel of filter width.

The shift of a zero of the Laplacian of Gaussian by shading or a marker grows with sigma^2. Read off
the centre errors of eight shots of spheres with 16 markers: 0.05 px at sigma 1.2 and 0.14 px at 2
(docs/decisions/0004-slow-errors.md has other films).
"""
TURN_PER_CENTRE_ERROR = 1.5
"""An error of the centre tilts every marker's direction; both views together tilt by this much."""
SHORTEST_S, LONGEST_S = 1e-3, 1.0


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
        gap = np.abs(times_s[:, None] - times_s[None, :])
        return np.asarray(self.sigma**2 * np.exp(-gap / self.correlation_time_s))


def centre_drift(filter_sigma_px: float, scale_px_per_m: float, correlation_time_s: float) -> Drift:
    """Return the slow error of a centre coordinate, m."""
    return Drift(CENTRE_DRIFT_PER_SIGMA2 * filter_sigma_px**2 / scale_px_per_m, correlation_time_s)


def turn_drift(filter_sigma_px: float, radius_px: float, correlation_time_s: float) -> Drift:
    """Return the slow error of an orientation about each axis, rad."""
    centre = CENTRE_DRIFT_PER_SIGMA2 * filter_sigma_px**2 / radius_px
    return Drift(TURN_PER_CENTRE_ERROR * centre, correlation_time_s)


def correlation_time(marker_angle: float, spin_rad_per_s: float) -> float:
    """Return the time in which a marker turns by its own width, s.

    Errors of poses of rendered flights last about as long, whatever the renderer
    (docs/decisions/0035-slow-errors-by-campaign.md).
    """
    width = max(2 * marker_angle, 0.05)
    return float(np.clip(width / max(spin_rad_per_s, 1e-6), SHORTEST_S, LONGEST_S))
