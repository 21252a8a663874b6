"""Oblique impact of compliant spheres: springs that each stick or slip.

Two laws of contact. The annuli of N. Maw, J. R. Barber and J. N. Fawcett, Wear 38, 101 (1976), are
equivalent to independent springs on a line (method of dimensionality reduction: V. L. Popov and
M. Hess 2015; I. A. Lyashenko and V. L. Popov, Sci. Rep. 5, 8479 (2015)), here with a dashpot along
the normal in each. Contact codes use a single spring: P. A. Cundall and O. D. L. Strack,
Geotechnique 29, 47 (1979), on Hertz's force with the damping of Y. Tsuji, T. Tanaka and T. Ishida,
Powder Technol. 71, 239 (1992).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.resources import files

import numpy as np

from analysis.arrays import Floats

SPRINGS, STEPS = 100, 1000
DEEPEST = (15 / 16) ** 0.4
"""Hertz's largest overlap in units m* = R* = E* = v_n = 1, with overlaps d - x^2 on the line."""
PSI = np.concatenate([np.arange(0.0, 8.0, 0.05), np.geomspace(8.0, 100.0, 30)])
"""Incidences of a table; beyond them a contact slides throughout."""
_CHI_STEP, _E_STEP = 0.05, 0.05
_LEAST_E = 0.3
TABLES = "spring_slider_tables.npz"


Pressing = Callable[[float, float, float], tuple[Floats, Floats]]
"""From overlap, its rate and the damping to the force on each spring along the normal and its
stiffness along the normal, both of shape (springs,), in units m* = R* = E* = v_n = 1."""

_WIDTH = 1.02 * np.sqrt(DEEPEST) / SPRINGS
_PROFILE = ((np.arange(SPRINGS) + 0.5) * _WIDTH) ** 2


def line_of_springs(depth: float, rate: float, damping: float) -> tuple[Floats, Floats]:
    """Press Maw's sphere: springs at distance x from the middle, pressed by depth - x^2."""
    touching = 2 * _WIDTH * (depth > _PROFILE)
    return touching * (depth - _PROFILE + damping * rate).clip(min=0.0), touching


def single_spring(depth: float, rate: float, damping: float) -> tuple[Floats, Floats]:
    """Press Cundall's and Strack's sphere: one spring, as stiff as Hertz's force at that depth.

    As its stiffness follows the depth, it can return more than it took: D. Elata and
    J. G. Berryman, Mech. Mater. 24, 229 (1996). With nylon's losses the whole contact never does.
    """
    root = np.sqrt(np.array([depth]))
    force = 4 / 3 * root**3 + damping * np.sqrt(root) * rate
    return force.clip(min=0.0), 2 * root


def rebound(psi: Floats, chi: float, e: Floats, pressing: Pressing = line_of_springs) -> Floats:
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
    pressing
        The law of contact.

    Beyond `psi` = 7 kappa - 1 Maw's elastic solid spheres slide throughout, with
    f = psi - 2 (1 + e) chi. Between tables the shape is interpolated, each table being moved to the
    required e by s = (1 + e) / (1 + e_table) in place of v_n: the sliding line stays exact.
    """
    column = round(chi / _CHI_STEP, 9)
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
                moved = _moved(
                    psi[rows], chi, e[rows], _held(pressing, j * _CHI_STEP, table_e), table_e
                )
                total[rows] += weight * near_e[rows] * moved
    return total


def _moved(psi: Floats, chi: float, e: Floats, held: Floats, table_e: float) -> Floats:
    """Return f from one table by its difference to the sliding line."""
    scale = (1 + e) / (1 + table_e)
    return psi - 2 * (1 + e) * chi + scale * np.interp(psi / scale, PSI, held, right=0.0)


@cache
def _held(pressing: Pressing, chi: float, e: float) -> Floats:
    """Return f - psi + 2 (1 + e) chi, how far the contact is from sliding, on `PSI`."""
    kept = kept_tables().get(table_name(pressing, chi, e))
    return integrated(pressing, chi, e) if kept is None else kept


def table_name(pressing: Pressing, chi: float, e: float) -> str:
    """Return the name under which a table is kept."""
    return f"{pressing.__name__} chi {chi:.2f} e {e:.2f}"


@cache
def kept_tables() -> dict[str, Floats]:
    """Return the tables that come with the project: solid spheres at the ratios of the catalogue.

    Each takes about a tenth of a second to integrate.
    """
    with (files("analysis.effects.contact") / TABLES).open("rb") as file, np.load(file) as tables:
        return {name: tables[name].astype(np.float64) for name in tables.files}


def integrated(pressing: Pressing, chi: float, e: float) -> Floats:
    """Integrate a table."""
    damping = dashpot(round(e, 6), pressing)
    table, true_e = impact(PSI, 2 * chi / 3.5, 3.5, damping, pressing)
    return table - (PSI - 2 * (1 + true_e) * chi)


def impact(
    psi: Floats, kappa: float, lever: float, damping: float, pressing: Pressing = line_of_springs
) -> tuple[Floats, float]:
    """Integrate one impact for every incidence at once, to second order in time.

    Parameters
    ----------
    lever
        1 + 1/K: change of surface velocity for each change of the centres' velocity.
    damping
        Of the dashpot along the normal, as `dashpot` gives it.

    Returns
    -------
    Rebound f, shape of psi, and the normal restitution of the same springs.
    """
    step = 2.9432 * DEEPEST / STEPS
    stretch = np.zeros((psi.size, 1))
    slip, depth, speed = psi / kappa, 0.0, 1.0
    push, drag = 0.0, np.zeros(psi.size)
    while True:
        speed -= push * step / 2
        slip = slip - lever * drag * step / 2
        depth += speed * step
        if depth <= 0.0:
            return kappa * slip, -speed
        force, stiffness = pressing(depth, speed, damping)
        limit = np.divide(force, kappa * stiffness, out=np.zeros_like(force), where=stiffness > 0)
        stretch = np.clip(stretch + (slip * step)[:, None], -limit, limit)
        push = float(force.sum())
        drag = kappa * (stretch * stiffness).sum(axis=1)
        speed -= push * step / 2
        slip = slip - lever * drag * step / 2


@cache
def dashpot(e: float, pressing: Pressing = line_of_springs) -> float:
    """Return the damping that gives a normal restitution, 0.3 to 1."""
    if e >= 1.0:
        return 0.0
    # Listing effects does not need it, and loading it is slow.
    from scipy.optimize import brentq  # noqa: PLC0415

    def excess(damping: float) -> float:
        return impact(np.zeros(1), 1.0, 3.5, damping, pressing)[1] - e

    return float(brentq(excess, 0.0, 3.0, xtol=1e-9))
