"""Oblique impact of compliant spheres: independent springs with friction on a line.

The annuli of N. Maw, J. R. Barber and J. N. Fawcett, Wear 38, 101 (1976), for Hertz's contact with
friction are equivalent to springs on a line that each stick or slip (method of dimensionality
reduction: V. L. Popov and M. Hess 2015; I. A. Lyashenko and V. L. Popov, Sci. Rep. 5, 8479
(2015)). A dashpot in each normal spring makes the impact inelastic.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Floats = NDArray[np.float64]

SPRINGS, STEPS = 100, 1000
DEEPEST = (15 / 16) ** 0.4
"""Hertz's largest overlap in units m* = R* = E* = v_n = 1, with overlaps d - x^2 on the line."""
PSI = np.concatenate([np.arange(0.0, 8.0, 0.05), np.geomspace(8.0, 100.0, 30)])
"""Incidences of a table; beyond them a contact slides throughout."""
_CHI_STEP, _E_STEP = 0.05, 0.05
_LEAST_E = 0.3


def rebound(psi: Floats, chi: float, e: Floats) -> Floats:
    """Return the rebound f = kappa v_s' / (mu v_n) for each incidence psi = kappa v_s / (mu v_n).

    Parameters
    ----------
    psi
        Not negative, shape (S,).
    chi
        kappa (1 + 1/K) / 2, kappa the ratio of tangential to normal stiffness,
        2 (1 - nu) / (2 - nu) for like spheres.
    e
        Normal restitution, shape (S,); below 0.3 the shape is that of 0.3.

    Beyond `psi` = 7 kappa - 1 (elastic solid spheres) the contact slides throughout and
    f = psi - 2 (1 + e) chi. Between tables the shape is interpolated, each table being moved to the
    wanted e by s = (1 + e) / (1 + e_table) in place of v_n: the sliding line stays exact.
    """
    column = chi / _CHI_STEP
    low = int(np.floor(column))
    row = (e.clip(_LEAST_E, 1.0) - _LEAST_E) / _E_STEP
    total = np.zeros_like(psi)
    for k in np.unique([np.floor(row), np.floor(row) + 1]):
        near_e = (1 - np.abs(row - k)).clip(min=0.0)
        rows = np.flatnonzero(near_e > 0)
        if rows.size == 0:
            continue
        table_e = min(_LEAST_E + _E_STEP * float(k), 1.0)
        for j, weight in ((low, 1 - (column - low)), (low + 1, column - low)):
            if weight > 0:
                moved = _moved(psi[rows], chi, e[rows], j * _CHI_STEP, table_e)
                total[rows] += weight * near_e[rows] * moved
    return total


def _moved(psi: Floats, chi: float, e: Floats, table_chi: float, table_e: float) -> Floats:
    """Return f from one table by its difference to the sliding line."""
    scale = (1 + e) / (1 + table_e)
    held = np.interp(psi / scale, PSI, _held(table_chi, table_e), right=0.0)
    return psi - 2 * (1 + e) * chi + scale * held


@cache
def _held(chi: float, e: float) -> Floats:
    """Return f - psi + 2 (1 + e) chi, how far the contact is from sliding, on `PSI`."""
    table, true_e = impact(PSI, 2 * chi / 3.5, 3.5, dashpot(round(e, 6)))
    return table - (PSI - 2 * (1 + true_e) * chi)


def impact(psi: Floats, kappa: float, lever: float, damping: float) -> tuple[Floats, float]:
    """Integrate one impact for every incidence at once, to second order in time.

    Parameters
    ----------
    lever
        1 + 1/K: change of surface velocity for each change of the centres' velocity.
    damping
        Of a dashpot in each normal spring, as `dashpot` gives it.

    Returns
    -------
    Rebound f, shape of psi, and the normal restitution of the same springs.
    """
    width = 1.02 * np.sqrt(DEEPEST) / SPRINGS
    profile = ((np.arange(SPRINGS) + 0.5) * width) ** 2
    step = 2.9432 * DEEPEST / STEPS
    stretch = np.zeros((psi.size, SPRINGS))
    slip, depth, speed = psi / kappa, 0.0, 1.0
    push, drag = 0.0, np.zeros(psi.size)
    while True:
        speed -= push * step / 2
        slip = slip - lever * drag * step / 2
        depth += speed * step
        if depth <= 0.0:
            return kappa * slip, -speed
        spring = np.where(depth > profile, (depth - profile + damping * speed).clip(min=0.0), 0.0)
        limit = spring / kappa
        stretch = np.clip(stretch + (slip * step)[:, None], -limit, limit)
        push = 2 * width * float(spring.sum())
        drag = 2 * width * kappa * stretch.sum(axis=1)
        speed -= push * step / 2
        slip = slip - lever * drag * step / 2


@cache
def dashpot(e: float) -> float:
    """Return the damping that gives a normal restitution, 0.3 to 1."""
    if e >= 1.0:
        return 0.0
    nothing = np.zeros(1)
    return float(brentq(lambda c: impact(nothing, 1.0, 3.5, c)[1] - e, 0.0, 3.0, xtol=1e-9))
