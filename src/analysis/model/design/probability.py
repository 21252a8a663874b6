"""How likely the right one of two theories is to be named."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr
from scipy.stats import chi2 as chi2_distribution
from scipy.stats import ncx2

LEVEL = 0.001
"""Chance of a fall of chi-squared large enough for an effect to be named when nothing is missing:
three campaigns in a hundred among some thirty that are looked at."""


def named_over_rival(strength: float, apart: float, *, more: int = 0, shots: int = 2) -> float:
    """Return the probability that a true effect has a better criterion than its rival.

    Scores of effects with as many parameters are Gaussian with means d and rho d and correlation
    rho. With a = d sqrt((1 - rho) / 2) and b = d sqrt((1 + rho) / 2) the larger square is the right
    one's with probability Phi(a) Phi(b) + (1 - Phi(a)) (1 - Phi(b)). Where one has more parameters
    it gains a chi-squared of as many degrees by noise, and pays ln(shots) for each; the sum is
    taken as Gaussian.

    Parameters
    ----------
    strength
        d^2, the fall of chi-squared that the true effect brings.
    apart
        d^2 (1 - rho^2), chi-squared that the rival leaves after it was refitted.
    more
        Parameters that the true effect has more; below zero, fewer.
    """
    if more:
        mean = apart + more * (1 - np.log(shots))
        return float(ndtr(mean / np.sqrt(4 * apart + 2 * abs(more))))
    if apart <= 0:
        return 0.5
    strength = max(strength, apart)
    rho = np.sqrt(1 - apart / strength)
    a, b = np.sqrt(strength * (1 - rho) / 2), np.sqrt(strength * (1 + rho) / 2)
    return float(ndtr(a) * ndtr(b) + ndtr(-a) * ndtr(-b))


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
