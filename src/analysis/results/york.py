"""A straight line through points with errors in both coordinates, and their correlation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats

ITERATIONS = 200
SETTLED = 1e-14
LEAST_POINTS = 3


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """y = intercept + slope x.

    Attributes
    ----------
    slope, intercept
        In the units of the points.
    covariance
        Of (slope, intercept), as the points' errors give it, shape (2, 2).
    chi2, freedom
        Sum of the weighted squares of the residuals, and points less two.
    """

    slope: float
    intercept: float
    covariance: Floats
    chi2: float
    freedom: int

    def at(self, x: Floats) -> Floats:
        """Return the line's height."""
        return np.asarray(self.intercept + self.slope * x)

    def sigma_at(self, x: Floats) -> Floats:
        """Return the standard error of the line's height."""
        design = np.stack([x, np.ones_like(x)], axis=-1)
        return np.asarray(np.sqrt(np.einsum("...i,ij,...j", design, self.covariance, design)))


def york_line(
    x: Floats, y: Floats, sigma_x: Floats, sigma_y: Floats, correlation: Floats
) -> Line | None:
    """Fit the line that makes the true points' errors most likely.

    Minimises sum (y - a - b x)^2 / (sigma_y^2 + b^2 sigma_x^2 - 2 b r sigma_x sigma_y) over a and
    b, the true places along the line eliminated. D. York, N. M. Evensen, M. Lopez Martinez and
    J. De Basabe Delgado, Am. J. Phys. 72, 367 (2004), equations (13) for line and errors.

    Parameters
    ----------
    x, y, sigma_x, sigma_y, correlation
        Points, their standard errors, and the correlation of these, shape (N,).

    Returns
    -------
    None with fewer than three points, or where they all stand at one place.
    """
    if len(x) < LEAST_POINTS or np.ptp(x) == 0:
        return None
    slope = float(np.polyfit(x, y, 1)[0])
    for _ in range(ITERATIONS):
        weight, middle, adjusted = _adjusted(slope, (x, y), (sigma_x, sigma_y), correlation)
        better = float(
            (weight * adjusted * middle[1]).sum() / (weight * adjusted * middle[0]).sum()
        )
        done = abs(better - slope) <= SETTLED * max(abs(slope), 1.0)
        slope = better
        if done:
            break
    weight, middle, adjusted = _adjusted(slope, (x, y), (sigma_x, sigma_y), correlation)
    x_mean, y_mean = ((weight * part).sum() / weight.sum() for part in (x, y))
    intercept = float(y_mean - slope * x_mean)
    place = x_mean + adjusted
    centre = float((weight * place).sum() / weight.sum())
    variance = 1.0 / float((weight * (place - centre) ** 2).sum())
    covariance = variance * np.array([[1.0, -centre], [-centre, centre**2]])
    covariance[1, 1] += 1.0 / float(weight.sum())
    chi2 = float((weight * (y - intercept - slope * x) ** 2).sum())
    return Line(slope, intercept, covariance, chi2, len(x) - 2)


def _adjusted(
    slope: float, points: tuple[Floats, Floats], sigmas: tuple[Floats, Floats], correlation: Floats
) -> tuple[Floats, tuple[Floats, Floats], Floats]:
    """Return weights, distances from the weighted mean, and adjusted places less that mean."""
    (x, y), (sigma_x, sigma_y) = points, sigmas
    shared = correlation * sigma_x * sigma_y
    weight = 1.0 / (sigma_y**2 + slope**2 * sigma_x**2 - 2 * slope * shared)
    u = x - (weight * x).sum() / weight.sum()
    v = y - (weight * y).sum() / weight.sum()
    adjusted = weight * (u * sigma_y**2 + slope * v * sigma_x**2 - (slope * u + v) * shared)
    return weight, (u, v), adjusted
