"""Coefficients of every shot by itself, ratios of its velocities, with their errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.collision.coefficients import BETA_NEEDS_SIGMAS
from analysis.results.impacts import V_N, V_N_AFTER, V_S, V_S_AFTER, Impacts

Floats = NDArray[np.float64]

STEP = 1e-6
"""m/s, for derivatives."""


@dataclass(frozen=True, slots=True, eq=False)
class Ratio:
    """A ratio in each shot and its standard error, shape (S,); not a number where not measured."""

    value: Floats
    sigma: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Ratios:
    """The coefficients of section 7.1, shot by shot, and the axes of figure 7.4.

    Attributes
    ----------
    e
        Normal restitution, -v_n' / v_n.
    beta
        Rotational restitution, -v_s' / v_s; not a number where v_s is not told from zero.
    f
        Impulse across over impulse along the normal, (v_s - v_s') / ((1 + 1/K) (v_n' - v_n)): the
        coefficient of friction where the contact slides, less where it sticks.
    incidence, rebound
        v_s / |v_n| and v_s' / |v_n|.
    correlation
        Between the errors of incidence and rebound, shape (S,).
    """

    e: Ratio
    beta: Ratio
    f: Ratio
    incidence: Ratio
    rebound: Ratio
    correlation: Floats


def ratios(impacts: Impacts) -> Ratios:
    """Return the coefficients of every shot, errors to first order."""
    lever = impacts.lever

    # As of a single shot: a ratio to what is not told from zero has no meaning.
    spread_s = np.sqrt(impacts.covariance[:, V_S, V_S])
    told = impacts.velocities[:, V_S] > BETA_NEEDS_SIGMAS * spread_s

    def all_of(v: Floats) -> Floats:
        approach, sliding = -v[:, V_N], v[:, V_S]
        impulse = lever * (v[:, V_N_AFTER] + approach)
        return np.stack(
            [
                v[:, V_N_AFTER] / approach,
                np.where(told, -v[:, V_S_AFTER] / sliding, np.nan),
                (sliding - v[:, V_S_AFTER]) / impulse,
                sliding / approach,
                v[:, V_S_AFTER] / approach,
            ],
            axis=1,
        )

    values, covariance = _carried(all_of, impacts)
    sigma = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    e, beta, f, incidence, rebound = (Ratio(values[:, k], sigma[:, k]) for k in range(5))
    spread = np.where(sigma[:, 3] * sigma[:, 4] > 0, sigma[:, 3] * sigma[:, 4], 1.0)
    return Ratios(e, beta, f, incidence, rebound, covariance[:, 3, 4] / spread)


def _carried(function: Callable[[Floats], Floats], impacts: Impacts) -> tuple[Floats, Floats]:
    """Return values (S, K) of a function of the velocities and their covariance (S, K, K)."""
    here = impacts.velocities
    values = function(here)
    slopes = np.stack(
        [
            (function(here + STEP * axis) - function(here - STEP * axis)) / (2 * STEP)
            for axis in np.eye(4)
        ],
        axis=2,
    )
    # A ratio that takes no part of an unmeasured velocity must not inherit its absence.
    unmeasured = np.isnan(values)
    slopes = np.where(unmeasured[..., None], 0.0, np.nan_to_num(slopes))
    covariance = slopes @ impacts.covariance @ slopes.swapaxes(1, 2)
    rows, columns = np.nonzero(unmeasured)
    covariance[rows, columns, columns] = np.nan
    return values, covariance
