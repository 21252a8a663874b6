"""The noise of a table that does not state it: one scale, taken from the scatter about the law."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2 as chi2_distribution

from analysis.model.fit import Fit, fit_campaign
from analysis.model.tables import ContactTable
from analysis.model.theory import Theory

ROUNDS = 8
SETTLED = 0.01
LEAST_SPREAD = 1e-9
"""Of sigmas over their first guess: less is the rounding of a table that fits exactly."""


def with_scatter_as_noise(table: ContactTable, theory: Theory | None = None) -> ContactTable:
    """Multiply all sigmas by one factor, so that a theory fits as well as noise lets it.

    The factor is that of the median shot, which bad shots do not move: its chi-squared is set to
    the median of its distribution. The prior of beta0 does not scale with the noise, so the factor
    is found in a few rounds.

    Parameters
    ----------
    theory
        Law and effects to start from; None: the hard-sphere operator alone.

    Raises
    ------
    ValueError
        More is fitted than is tabulated, or the table fits exactly.
    """
    whole = 1.0
    for _ in range(ROUNDS):
        factor = _factor(fit_campaign(table, theory))
        whole *= factor
        if whole < LEAST_SPREAD:
            raise ValueError("the numbers fit the model exactly, so that there is no scatter")
        table = table.scaled(factor)
        if abs(factor - 1) < SETTLED:
            break
    return table


def _factor(fit: Fit) -> float:
    """Return by what the sigmas are to be multiplied."""
    left = fit.shot_residuals - fit.own_numbers
    if fit.freedom < 1 or not (left > 0).any():
        raise ValueError(
            f"{fit.residuals} numbers leave no scatter about {fit.residuals - fit.freedom} fitted "
            "ones"
        )
    told = left > 0
    # Fitted parameters take their share of the scatter from every shot alike.
    share = fit.freedom / left.sum()
    expected = share * chi2_distribution.median(left[told])
    return float(np.sqrt(np.median(fit.shot_chi2[told] / expected)))
