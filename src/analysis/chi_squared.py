"""The chi-squared distribution: how likely a sum of squares is, and which is how likely.

From `scipy.special`: loading `scipy.stats` takes longer than a fit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc, chdtri

from analysis.arrays import Floats


def chance_of_more(chi2: ArrayLike, freedom: ArrayLike) -> Floats:
    """Return the chance of a chi-squared at least as large, 1 without a degree of freedom.

    Parameters
    ----------
    chi2, freedom
        Numbers, or arrays that broadcast.
    """
    count = np.asarray(freedom, np.float64)
    return np.where(count > 0, chdtrc(np.maximum(count, 1), np.asarray(chi2, np.float64)), 1.0)


def limit(chance: ArrayLike, freedom: ArrayLike) -> Floats:
    """Return the chi-squared that chance alone exceeds so often."""
    return np.asarray(chdtri(np.asarray(freedom, np.float64), np.asarray(chance, np.float64)))


def median(freedom: ArrayLike) -> Floats:
    """Return the chi-squared that chance alone exceeds in one case of two."""
    return limit(0.5, freedom)
