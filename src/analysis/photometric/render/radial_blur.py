"""Radial functions of a disc blurred: the integrals over the radius, and a spline through them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

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
