"""How likely an effect is to be named where nothing else could be."""

from __future__ import annotations

from scipy.special import chndtr

from analysis import chi_squared

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
    least = chi_squared.limit(LEVEL, parameters)
    return 1.0 - float(chndtr(least, parameters, max(apart, 1e-12)))
