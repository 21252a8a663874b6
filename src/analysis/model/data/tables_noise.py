"""The noise of a table that does not state it, channel by channel, from the scatter about the law.

Velocities and spins of contacts, normal and surface velocities of impacts have a scale each, so
that good normal velocities are not buried under bad spins.
"""

from __future__ import annotations

import numpy as np

from analysis import chi_squared
from analysis.arrays import Floats
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.predict.comparison import compare
from analysis.model.predict.theory import Theory

ROUNDS = 12
SETTLED = 0.01
LEAST_SPREAD = 1e-9
"""Of sigmas over their first guess: less is the rounding of a table that fits exactly."""
LEAST_FREEDOM = 0.25
"""Of a channel in a shot: with less it has no scatter of its own, and takes that of all."""
LEAST_SINGULAR = 1e-9


def with_scatter_as_noise(table: ContactTable, theory: Theory | None = None) -> ContactTable:
    """Multiply the sigmas of each channel by a factor, so that a theory fits as noise lets it.

    The factor is that of the median shot, which bad shots do not move: the chi-squared of its
    channel is set to the median of its distribution. Which channel a fit gives way to depends on
    the factors, so they are found in a few rounds.

    Parameters
    ----------
    theory
        Law and effects to start from; None: the hard-sphere operator alone.

    Raises
    ------
    ValueError
        More is fitted than is tabulated, or the table fits exactly.
    """
    whole = np.ones(len(table.channels))
    for _ in range(ROUNDS):
        factors = _factors(table, fit_campaign(table, theory))
        whole *= factors
        if whole.min() < LEAST_SPREAD:
            raise ValueError("the numbers fit the model exactly, so that there is no scatter")
        table = table.scaled(factors @ table.channels)
        if (np.abs(factors - 1) < SETTLED).all():
            break
    return table


def _factors(table: ContactTable, fit: Fit) -> Floats:
    """Return by what the sigmas of each channel are to be multiplied, shape (channels,)."""
    left = fit.shot_residuals - fit.nuisance_count
    if fit.freedom < 1 or not (left > 0).any():
        raise ValueError(
            f"{fit.residuals} numbers leave no scatter about {fit.residuals - fit.freedom} fitted "
            "ones"
        )
    # Fitted parameters take their share of the scatter from every shot alike.
    share = fit.freedom / left.sum()
    squares, freedom = _scatter(table, fit)
    channels = table.channels.astype(np.float64)
    together = _factor(fit.shot_chi2, share * left)
    apart = zip((squares @ channels.T).T, share * (freedom @ channels.T).T, strict=True)
    return np.array([_factor(own, free) or together for own, free in apart])


def _factor(chi2: Floats, freedom: Floats) -> float:
    """Return the factor of the median shot, 0 where no shot has any freedom."""
    told = freedom > LEAST_FREEDOM
    if not told.any():
        return 0.0
    expected = chi_squared.median(freedom[told])
    return float(np.sqrt(np.median(chi2[told] / expected)))


def _scatter(table: ContactTable, fit: Fit) -> tuple[Floats, Floats]:
    """Return squares of whitened residuals and one less the leverage of each, shape (S, L).

    The leverage is that of the shot's own numbers.
    """
    line, _ = compare(table, fit.states, fit.theory)
    shots, length = table.sigma.shape
    slopes = line.slopes.reshape(shots, length, -1) @ line.by_state[:, :, table.open]
    left, singular, _ = np.linalg.svd(slopes, full_matrices=False)
    fitted = singular > LEAST_SINGULAR * singular.max(axis=1, keepdims=True)
    leverage = (left**2 * fitted[:, None, :]).sum(axis=2)
    squares = line.residual.reshape(shots, length) ** 2
    return squares, np.where(table.measured, 1.0 - leverage, 0.0)
