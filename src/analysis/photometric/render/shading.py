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
from scipy.special import i0e, i1e

from analysis.arrays import Floats
from analysis.photometric.render.radial_blur import blur_radials, pairs_near, refined

ORDER = 3
STEPS_PER_RADIUS = 400
REACH_SIGMAS = 5.0
KEPT_PROFILES = 8
COARSE_PER_SIGMA = 3.0
NODES_PER_SIGMA, NODE_STEP, MOST_NODES = 5.0, 64, 640
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
ANGULAR = np.array([f.angular for f in RADIALS])
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
    shapes = np.stack([t**f.power * height**f.height * measure for f in RADIALS], axis=1)
    reach = 1.0 + REACH_SIGMAS * sigma
    rho = np.linspace(0.0, reach, int(np.ceil(reach * COARSE_PER_SIGMA / sigma)) + 1)
    ends, argument = pairs_near(rho, rho / sigma**2, t, sigma, REACH_SIGMAS + 1.0)
    bessel = np.asarray(i0e(argument)), np.asarray(i1e(argument))
    coarse = blur_radials((rho, t), ends, bessel, (shapes, ANGULAR), sigma)
    return Profiles(refined(coarse, rho[1], int(reach * STEPS_PER_RADIUS) + 1, STEPS_PER_RADIUS))


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
    mixing = np.zeros((len(RADIALS), COLUMNS + 1))
    for (j, sine), coefficient in zip(HARMONICS, coefficients, strict=True):
        m = RADIALS[j].angular
        mixing[j, 0 if m == 0 else 2 * m - 1 + sine] += coefficient
    mixing[0, DISC] = 1.0
    return np.asarray(profiles.values @ mixing)
