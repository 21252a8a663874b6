"""Coefficients of every shot by itself, ratios of its velocities, with their errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.collision.coefficients import BETA_NEEDS_SIGMAS
from analysis.quantity import own_part
from analysis.results.impacts import V_N, V_N_AFTER, V_S, V_S_AFTER, Impacts

STEP = 1e-6
"""m/s, for derivatives."""


@dataclass(frozen=True, slots=True, eq=False)
class Ratio:
    """A number in each shot and its standard error, shape (S,); not a number where not measured.

    Attributes
    ----------
    common
        Part of the error that all shots share; not a number where the parts are not separated.
    """

    value: Floats
    sigma: Floats
    common: Floats

    @property
    def own(self) -> Floats:
        """Return the part of the error that is each shot's own."""
        return own_part(self.sigma, self.common)


@dataclass(frozen=True, slots=True, eq=False)
class Ratios:
    """The coefficients of section 7.1, shot by shot, and the axes of figure 7.4.

    Attributes
    ----------
    e
        Normal restitution, -v_n' / v_n.
    beta
        Rotational restitution, -v_s' / v_s; not a number where v_s is compatible with zero.
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

    # As in a single shot: a ratio to a value compatible with zero has no meaning.
    spread_s = np.sqrt(impacts.covariance[:, V_S, V_S])
    above_zero = impacts.velocities[:, V_S] > BETA_NEEDS_SIGMAS * spread_s

    def all_of(v: Floats) -> Floats:
        approach, sliding = -v[:, V_N], v[:, V_S]
        impulse = lever * (v[:, V_N_AFTER] + approach)
        return np.stack(
            [
                v[:, V_N_AFTER] / approach,
                np.where(above_zero, -v[:, V_S_AFTER] / sliding, np.nan),
                (sliding - v[:, V_S_AFTER]) / impulse,
                sliding / approach,
                v[:, V_S_AFTER] / approach,
            ],
            axis=1,
        )

    values, slopes = _linear(all_of, impacts.velocities)
    covariance = slopes @ impacts.covariance @ slopes.swapaxes(1, 2)
    every = _split(values, covariance, slopes, impacts.common)
    e, beta, f, incidence, rebound = every
    sigma = np.stack([one.sigma for one in every], axis=1)
    spread = np.where(sigma[:, 3] * sigma[:, 4] > 0, sigma[:, 3] * sigma[:, 4], 1.0)
    return Ratios(e, beta, f, incidence, rebound, covariance[:, 3, 4] / spread)


def velocities(impacts: Impacts) -> tuple[Ratio, ...]:
    """Return v_n, v_s, v_n' and v_s' of every shot, m/s, with the parts of their errors."""
    slopes = np.tile(np.eye(4), (len(impacts.shots), 1, 1))
    return _split(impacts.velocities, impacts.covariance, slopes, impacts.common)


def _split(
    values: Floats, covariance: Floats, slopes: Floats, common: Floats | None
) -> tuple[Ratio, ...]:
    """Return numbers (S, K) with their errors, and what of these all shots share.

    Parameters
    ----------
    covariance
        Shape (S, K, K).
    slopes, common
        Derivatives by the velocities, shape (S, K, 4), and the part of the velocities' covariance
        that all shots share; None: not separated.
    """
    spread = np.diagonal(covariance, axis1=1, axis2=2)
    shared = np.full(spread.shape, np.nan)
    if common is not None:
        shared = np.diagonal(slopes @ common @ slopes.swapaxes(1, 2), axis1=1, axis2=2)
    measured = np.isfinite(values)
    # What rounding leaves of a share that a ratio has none of may be negative.
    seen = (np.where(measured, each.clip(min=0.0), np.nan) for each in (spread, shared))
    sigma, part = map(np.sqrt, seen)
    return tuple(Ratio(values[:, k], sigma[:, k], part[:, k]) for k in range(values.shape[1]))


def _linear(function: Callable[[Floats], Floats], here: Floats) -> tuple[Floats, Floats]:
    """Return values (S, K) of a function of the velocities and its slopes (S, K, 4)."""
    values = function(here)
    slopes = np.stack(
        [
            (function(here + STEP * axis) - function(here - STEP * axis)) / (2 * STEP)
            for axis in np.eye(4)
        ],
        axis=2,
    )
    # A ratio that takes no part of an unmeasured velocity must not inherit its absence.
    return values, np.where(np.isnan(values)[..., None], 0.0, np.nan_to_num(slopes))
