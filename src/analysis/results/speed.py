"""Restitution against approach speed (thesis, figure 3.1c)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.results.impacts import V_N, V_N_AFTER, Impacts
from analysis.results.ratios import Ratios
from analysis.results.york import Line, york_line

Floats = NDArray[np.float64]


def speed_line(impacts: Impacts, found: Ratios, used: NDArray[np.bool_]) -> Line | None:
    """Fit e = e_0 + slope |v_n|, errors of both and their correlation by the shared v_n.

    A line is the first order of whatever law holds over the speeds of a campaign; slope in s/m.
    None where the shots do not tell one. `used`, shape (S,), says which shots count.
    """
    sigma_speed = np.sqrt(impacts.covariance[:, V_N, V_N])
    columns = (
        *(impacts.approach, found.e.value, sigma_speed, found.e.sigma),
        _correlation(impacts, found),
    )
    return york_line(*(column[used] for column in columns))


def _correlation(impacts: Impacts, found: Ratios) -> Floats:
    """Return the correlation of the errors of |v_n| and e = v_n' / |v_n|, shape (S,)."""
    v, c = impacts.approach, impacts.covariance
    # With |v_n| = -v_n: cov(|v_n|, e) = -cov(v_n, v_n') / |v_n| - e var(v_n) / |v_n|.
    shared = -(c[:, V_N, V_N_AFTER] + found.e.value * c[:, V_N, V_N]) / v
    spread = np.sqrt(c[:, V_N, V_N]) * found.e.sigma
    return np.asarray(np.where(spread > 0, shared / np.where(spread > 0, spread, 1.0), 0.0))
