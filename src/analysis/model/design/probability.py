"""How likely an effect is to be named where nothing else could be."""

from __future__ import annotations

from scipy.stats import chi2 as chi2_distribution
from scipy.stats import ncx2

LEVEL = 0.001
"""Chance of a fall of chi-squared large enough for an effect to be named when nothing is missing:
three campaigns in a hundred among some thirty that are looked at."""


def named_over_none(apart: float, parameters: int) -> float:
    """Return the probability that a true effect passes the level at which it is named.

    Parameters
    ----------
    apart
        Chi-squared that the base model leaves without the effect.
    parameters
        Of the effect.
    """
    least = chi2_distribution.isf(LEVEL, parameters)
    return float(ncx2.sf(least, parameters, max(apart, 1e-12)))
