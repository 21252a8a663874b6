"""Results as tables, one for each figure and one for the shots; first row the columns' names.

SI units, which the names end in; a ratio has none. What was not measured is empty.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import WaltonLaw
from analysis.effects.contact.tangential_compliance import maw_curve
from analysis.results.campaign import Results
from analysis.results.impacts import V_N, Impacts
from analysis.results.likelihood import transition
from analysis.results.lines import regression_curve
from analysis.results.published import THESIS
from analysis.results.ratios import Ratio, velocities

Table = list[list[object]]

VELOCITIES = ("v_n", "v_s", "v_n_after", "v_s_after")
CURVE = 240
NEAR = 2.4
"""The curves are drawn densely up to so many times the place where the lines meet."""


def tables(found: Results) -> dict[str, Table]:
    """Return every table under its file's name."""
    return {
        "coefficients": _coefficients(found),
        "parameters": _parameters(found),
        "figure-7-4": _plane(found),
        "figure-7-4-curves": _curves(found),
        "restitution": _restitution(found),
        "residuals": _residuals(found),
        "left-out": _left_out(found),
    }


def _left_out(found: Results) -> Table:
    both = sorted([*found.left_out, *found.far], key=lambda one: one.shot)
    return [["shot", "reason"], *([one.shot, one.reason] for one in both)]


def _coefficients(found: Results) -> Table:
    impacts, each = found.impacts, found.ratios
    columns: dict[str, Iterable[object]] = {"shot": impacts.shots}
    for name, speed in zip(VELOCITIES, velocities(impacts), strict=True):
        columns |= _with_parts(f"{name}_m_per_s", speed)
    for i in range(4):
        for j in range(i):
            pair = f"correlation_{VELOCITIES[j]}_{VELOCITIES[i]}"
            columns[pair] = _correlation(impacts, i, j)
    for name, ratio in (("e", each.e), ("beta", each.beta), ("f", each.f)):
        columns |= _with_parts(name, ratio)
    columns["probability_of_sliding"] = found.lines.held.slides
    columns["in_regression"] = found.lines.used.astype(int)
    return _table(columns)


def _correlation(impacts: Impacts, i: int, j: int) -> Floats:
    c = impacts.covariance
    spread = np.sqrt(c[:, i, i] * c[:, j, j])
    known = (spread > 0) & np.isfinite(impacts.velocities[:, [i, j]]).all(axis=1)
    return np.asarray(np.where(known, c[:, i, j] / np.where(known, spread, 1.0), np.nan))


def _parameters(found: Results) -> Table:
    rows: Table = [["parameter", "regression", "sigma", "whole_fit", "sigma_whole_fit", "thesis"]]
    regression, whole = found.coefficients(), found.whole_fit
    of_contacts = [name for name in whole if found.lasting and name not in THESIS]
    for name in (*THESIS, *of_contacts):
        row: list[object] = [name]
        for quantity in (regression.get(name), whole.get(name)):
            known = quantity is not None and quantity.determined
            row += [quantity.value, quantity.sigma] if quantity and known else ["", ""]
        rows.append([*row, THESIS.get(name, "")])
    return rows


def _plane(found: Results) -> Table:
    each = found.ratios
    columns = {
        "shot": found.impacts.shots,
        **_pair("v_s_over_v_n", each.incidence),
        **_pair("v_s_after_over_v_n", each.rebound),
        "correlation": each.correlation,
        "probability_of_sliding": found.lines.held.slides,
    }
    return _table(columns, found.impacts.surface)


def _curves(found: Results) -> Table:
    x = curve_places(found)
    law, lever = found.lines.law, found.impacts.lever
    columns: dict[str, Iterable[object]] = {
        "v_s_over_v_n": x,
        "walton": regression_curve(found.lines, lever, x),
    }
    if "mu" in found.lines.fitted:
        columns["maw_barber_fawcett"] = maw_curve(law.e, law.mu, lever, x)
    return _table(columns)


def curve_places(found: Results) -> Floats:
    """Return the v_s / |v_n| at which curves are drawn: densely at the corner, and past all."""
    farthest = float(np.nanmax(found.ratios.incidence.value, initial=0.5))
    near = np.linspace(0.0, min(NEAR * corner_of(found), 1.05 * farthest), CURVE)
    return np.unique(np.concatenate([near, np.linspace(near[-1], 1.05 * farthest, CURVE)]))


def corner_of(found: Results) -> float:
    """Return v_s / |v_n| where the lines meet; undetermined parameters are the thesis's."""
    law = {**THESIS, **{name: getattr(found.lines.law, name) for name in found.lines.fitted}}
    return transition(WaltonLaw(**law), found.impacts.lever)


def _restitution(found: Results) -> Table:
    sigma = np.sqrt(found.impacts.covariance[:, V_N, V_N])
    columns = {
        "shot": found.impacts.shots,
        "approach_m_per_s": found.impacts.approach,
        "sigma_approach_m_per_s": sigma,
        **_pair("e", found.ratios.e),
    }
    return _table(columns)


def _residuals(found: Results) -> Table:
    held = found.lines.held
    slides = np.nan_to_num(held.slides) > 0.5
    along = np.where(slides, held.sliding.residual, held.sticking.residual)
    error = np.where(slides, held.sliding.sigma, held.sticking.sigma)
    surface = np.isfinite(held.slides)
    columns = {
        "shot": found.impacts.shots,
        "normal_m_per_s": held.normal_residual,
        "sigma_normal_m_per_s": held.normal_sigma,
        "surface_m_per_s": np.where(surface, along, np.nan),
        "sigma_surface_m_per_s": np.where(surface, error, np.nan),
        "chi2": held.chi2,
    }
    return _table(columns)


def _pair(name: str, ratio: Ratio) -> dict[str, Iterable[object]]:
    return {name: ratio.value, f"sigma_{name}": ratio.sigma}


def _with_parts(name: str, ratio: Ratio) -> dict[str, Iterable[object]]:
    """Return value, error, and the parts of the error: each shot's own, and what all share."""
    return {
        **_pair(name, ratio),
        f"sigma_own_{name}": ratio.own,
        f"sigma_common_{name}": ratio.common,
    }


def _table(columns: Mapping[str, Iterable[object]], rows: NDArray[np.bool_] | None = None) -> Table:
    parts = [np.asarray(values) for values in columns.values()]
    chosen = parts if rows is None else [part[rows] for part in parts]
    body = zip(*(part.tolist() for part in chosen), strict=True)
    return [list(columns), *([_cell(value) for value in row] for row in body)]


def _cell(value: object) -> object:
    return "" if isinstance(value, float) and not math.isfinite(value) else value
