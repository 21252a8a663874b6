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
from scipy.special import i0e, i1e

from analysis.arrays import Floats
from analysis.compiled import compiled

Integers = NDArray[np.int64]

SMALL = 1e-3
"""Argument of a Bessel function below which its leading term is exact to 1e-6 of itself."""


@compiled
def pairs_near(
    rho: Floats, shares: Floats, t: Floats, sigma: float, reach: float
) -> tuple[Integers, Floats]:
    """Return the nodes near each radius, and the argument of the Bessel functions there.

    Parameters
    ----------
    rho, t
        Radii and nodes of the integral, both ascending.
    shares
        rho / sigma^2. Computed here it would be two products a pair, in an order that depends on
        the addresses of the arrays (decision 0017).
    sigma, reach
        Of the blur, in radii; nodes nearer than so many of it are near.

    Returns
    -------
    First node and the one behind the last for each radius, shape (radii, 2); rho t / sigma^2 of
    all pairs, radius after radius, shape (pairs,).
    """
    ends, count, first, behind = np.zeros((rho.size, 2), dtype=np.int64), 0, 0, 0
    for i in range(rho.size):
        while first < t.size and t[first] <= rho[i] - reach * sigma:
            first += 1
        while behind < t.size and t[behind] < rho[i] + reach * sigma:
            behind += 1
        ends[i, 0], ends[i, 1] = first, behind
        count += behind - first
    argument, n = np.empty(count), 0
    for i in range(rho.size):
        for k in range(ends[i, 0], ends[i, 1]):
            argument[n] = shares[i] * t[k]
            n += 1
    return ends, argument


@compiled
def blur_radials(
    places: tuple[Floats, Floats],
    ends: Integers,
    bessel: tuple[Floats, Floats],
    radials: tuple[Floats, Integers],
    sigma: float,
) -> Floats:
    """Return the blurred radial functions at some radii, shape (radii, radials).

    Parameters
    ----------
    places, ends
        Radii and nodes, and what `pairs_near` returned for them.
    bessel
        exp(-x) I_0(x) and exp(-x) I_1(x) of the pairs.
    radials
        Each function at the nodes times their weights, shape (nodes, radials), and its angular
        order.

    Notes
    -----
    Higher orders follow by recurrence, whose errors stay at rounding beyond SMALL; before it the
    leading term serves.
    """
    (rho, t), (shapes, angular), n = places, radials, 0
    blurred, orders = np.zeros((rho.size, angular.size)), np.zeros(max(angular.max(), 1) + 1)
    for i in range(rho.size):
        share = rho[i] / sigma**2
        for k in range(ends[i, 0], ends[i, 1]):
            x, gap = share * t[k], (rho[i] - t[k]) / sigma
            orders[0], orders[1] = bessel[0][n], bessel[1][n]
            leading = x / 2
            for m in range(2, orders.size):
                leading *= x / (2 * m)
                beyond = orders[m - 2] - 2 * (m - 1) / max(x, SMALL) * orders[m - 1]
                orders[m] = leading if x < SMALL else beyond
            bell = math.exp(-0.5 * gap * gap)
            for m in range(orders.size):
                orders[m] *= bell
            for j in range(angular.size):
                blurred[i, j] += orders[angular[j]] * shapes[k, j]
            n += 1
    return blurred


@compiled
def refined(values: Floats, step: float, count: int, per_unit: int) -> Floats:
    """Return the cubic spline through equidistant values at `count` points, from the first on.

    With the ends of C. de Boor, A Practical Guide to Splines, 1978, chapter 4 ("not a knot"):
    there the third derivative goes on through the second value, which makes the bends there a
    sixth of the values' second differences.

    Parameters
    ----------
    values
        A column for each function, at least 4 of them, shape (knots, functions).
    step, per_unit
        Distance between two values, and number of points in a distance of 1.
    """
    knots, functions = values.shape
    bends, share = np.zeros((knots, functions)), np.zeros(knots)
    last = knots - 2
    for i in range(1, knots - 1):
        for j in range(functions):
            bends[i, j] = values[i - 1, j] - 2 * values[i, j] + values[i + 1, j]
    # Elimination of bend[i - 1] + 4 bend[i] + bend[i + 1] = 6 differences, both ends being known.
    for i in range(2, last):
        share[i] = 1.0 / (4.0 - share[i - 1])
        for j in range(functions):
            bends[i, j] = (6 * bends[i, j] - bends[i - 1, j]) * share[i]
    for i in range(last - 1, 1, -1):
        for j in range(functions):
            bends[i, j] -= share[i] * bends[i + 1, j]
    for j in range(functions):
        bends[0, j] = 2 * bends[1, j] - bends[2, j]
        bends[knots - 1, j] = 2 * bends[last, j] - bends[last - 1, j]
    fine = np.empty((count, functions))
    for n in range(count):
        at = n / (per_unit * step)
        i = min(int(at), last)
        b = at - i
        a = 1.0 - b
        low, high = (a * a * a - a) / 6, (b * b * b - b) / 6
        for j in range(functions):
            own = a * values[i, j] + b * values[i + 1, j]
            fine[n, j] = own + low * bends[i, j] + high * bends[i + 1, j]
    return fine


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
