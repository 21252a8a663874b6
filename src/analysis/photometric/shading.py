"""What a smooth sphere looks like: spherical harmonics of its normal, blurred as the lens does.

On the visible half sphere the products rho^(m+2q) n_z^k cos(m theta) and sin(m theta) with
m + 2q + k <= order span all spherical harmonics up to that order. A blur that is the same in all
directions keeps the angular order m, so every function stays a radial profile times an angle and
is blurred once, by an integral over the radius, exactly up to the edge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.special import i0e, i1e

Floats = NDArray[np.float64]

ORDER = 3
STEPS_PER_RADIUS = 400
REACH_SIGMAS = 5.0
KEPT_PROFILES = 8
COARSE_PER_SIGMA = 3.0
NODES_PER_SIGMA, NODE_STEP, MOST_NODES = 5.0, 64, 640
SMALL = 1e-3
"""Argument of a Bessel function below which its leading term is exact to 1e-6 of itself."""
NUDGE = 1e-3
"""Step of a derivative taken by difference."""


@dataclass(frozen=True, slots=True)
class Radial:
    """One radial function rho^power n_z^height with angular order `angular`."""

    angular: int
    power: int
    height: int


RADIALS = tuple(
    Radial(m, m + 2 * q, k)
    for m in range(ORDER + 1)
    for k in (0, 1)
    for q in range(ORDER)
    if m + 2 * q + k <= ORDER
)
"""The first is the disc itself."""
HARMONICS = tuple(
    (j, sine) for j, f in enumerate(RADIALS) for sine in ((0, 1) if f.angular else (0,))
)
"""Index into RADIALS and 0 for cosine, 1 for sine: the coefficients of a shading in order."""
COLUMNS = 2 * ORDER + 1
DISC = COLUMNS
"""Column of a template behind its angular orders."""


@dataclass(frozen=True, slots=True, eq=False)
class Profiles:
    """Blurred radial functions against rho in steps of 1 / STEPS_PER_RADIUS.

    Attributes
    ----------
    values
        One column for each of RADIALS, shape (steps, radials).
    """

    values: Floats


@lru_cache(maxsize=KEPT_PROFILES)
def gauss_legendre(count: int) -> tuple[Floats, Floats]:
    """Return nodes and weights of an integral from -1 to 1; at most MOST_NODES of them."""
    nodes, weights = np.polynomial.legendre.leggauss(min(count, MOST_NODES))
    return np.asarray(nodes), np.asarray(weights)


@lru_cache(maxsize=KEPT_PROFILES)
def blurred_profiles(sigma: float) -> Profiles:
    """Blur all radial functions of the unit disc by a Gaussian.

    The profile of f(rho) cos(m theta) blurred by a Gaussian of standard deviation s is
    integral of f(t) t exp(-(rho^2 + t^2) / 2 s^2) I_m(rho t / s^2) / s^2 dt, I_m the modified
    Bessel function. With t = sin(x) the integrand is smooth to the edge.

    Parameters
    ----------
    sigma
        In units of the radius.
    """
    nodes, weights = gauss_legendre(NODE_STEP * math.ceil(NODES_PER_SIGMA / (sigma * NODE_STEP)))
    x = (nodes + 1) * np.pi / 4
    t, height = np.sin(x), np.cos(x)
    measure = weights * np.pi / 4 * height * t / sigma**2
    reach = 1.0 + REACH_SIGMAS * sigma
    rho = np.linspace(0.0, reach, int(np.ceil(reach * COARSE_PER_SIGMA / sigma)) + 1)
    gap = (rho[:, None] - t[None, :]) / sigma
    near = np.abs(gap) < REACH_SIGMAS + 1.0
    bell = np.exp(-0.5 * gap[near] ** 2)
    argument = (rho[:, None] * t[None, :])[near] / sigma**2
    coarse = np.zeros((len(rho), len(RADIALS)))
    for m, scaled in enumerate(_bessel(argument)):
        kernel = np.zeros(gap.shape)
        kernel[near] = bell * scaled
        columns = [j for j, f in enumerate(RADIALS) if f.angular == m]
        shapes = [t ** RADIALS[j].power * height ** RADIALS[j].height for j in columns]
        coarse[:, columns] = kernel @ (np.stack(shapes, 1) * measure[:, None])
    fine = np.arange(int(reach * STEPS_PER_RADIUS) + 1) / STEPS_PER_RADIUS
    values = CubicSpline(rho, coarse, axis=0)(fine)
    return Profiles(np.ascontiguousarray(values))


def _bessel(x: Floats) -> list[Floats]:
    """Return exp(-x) I_m(x) for the orders up to ORDER.

    By recurrence, whose errors stay at rounding beyond SMALL; the leading term before it.
    """
    orders = [np.asarray(i0e(x)), np.asarray(i1e(x))]
    small = x < SMALL
    safe = np.where(small, 1.0, x)
    for m in range(2, ORDER + 1):
        leading = (x / 2) ** m / math.factorial(m)
        orders.append(np.where(small, leading, orders[m - 2] - 2 * (m - 1) / safe * orders[m - 1]))
    return orders


def template(profiles: Profiles, coefficients: Floats) -> Floats:
    """Sum a shading into one profile for each angular order, with the disc behind them.

    Parameters
    ----------
    coefficients
        In the order of HARMONICS, shape (harmonics,).

    Returns
    -------
    Shape (steps, COLUMNS + 1): order 0, then cosine and sine of each order, DISC.
    """
    table = np.zeros((len(profiles.values), COLUMNS + 1))
    for (j, sine), coefficient in zip(HARMONICS, coefficients, strict=True):
        m = RADIALS[j].angular
        column = 0 if m == 0 else 2 * m - 1 + sine
        table[:, column] += coefficient * profiles.values[:, j]
    table[:, DISC] = profiles.values[:, 0]
    return table
