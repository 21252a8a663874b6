"""How likely the right one of two theories is to be named."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr
from scipy.stats import chi2 as chi2_distribution
from scipy.stats import ncx2

LEVEL = 0.001
"""Chance of a fall of chi-squared large enough for an effect to be named when nothing is missing:
three campaigns in a hundred among some thirty that are looked at."""
_REACH, _NODES = 8.0, 801


def named_over_rival(strength: float, apart: float, penalty: float = 0.0) -> float:
    """Return the probability that a true effect lowers chi-squared more than its rival.

    Their scores are Gaussian with means d and rho d and correlation rho. With a = d sqrt((1 -
    rho) / 2) and b = d sqrt((1 + rho) / 2) the larger square is the right one's with probability
    Phi(a) Phi(b) + (1 - Phi(a)) (1 - Phi(b)).

    Parameters
    ----------
    strength
        d^2, the fall of chi-squared that the true effect brings.
    apart
        d^2 (1 - rho^2), chi-squared that the rival leaves after it was refitted.
    penalty
        By how much the true one must be ahead, for having more parameters.
    """
    if apart <= 0:
        return 0.5 if penalty == 0 else float(penalty < 0)
    strength = max(strength, apart)
    rho = float(np.sqrt(1 - apart / strength))
    a, b = np.sqrt(strength * (1 - rho) / 2), np.sqrt(strength * (1 + rho) / 2)
    if penalty == 0:
        return float(ndtr(a) * ndtr(b) + ndtr(-a) * ndtr(-b))
    # z_A^2 - z_B^2 = 2 sqrt(1 - rho^2) u v with u, v independent of unit variance about a and b.
    least = penalty / (2 * np.sqrt(1 - rho**2))
    u = a + np.linspace(-_REACH, _REACH, _NODES)
    density = np.exp(-((u - a) ** 2) / 2)
    bound = least / np.where(u == 0, 1e-300, u)
    beyond = np.where(u > 0, ndtr(b - bound), ndtr(bound - b))
    return float((density * beyond).sum() / density.sum())


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
