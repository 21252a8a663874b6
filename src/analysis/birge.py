"""Birge ratio: by how much stated errors are enlarged where the scatter of a fit is larger.

R. T. Birge, Phys. Rev. 40, 207 (1932). A factor max(1, chi-squared over its freedom) is above 1 in
every second fit whose errors are stated rightly, and states those of ten numbers 8 % too large.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Floats
from analysis.chi_squared import chance_of_more

CONTRADICTED = 0.01
"""p-value of the scatter below which stated errors are enlarged."""


def variance_ratio(chi2: ArrayLike, freedom: ArrayLike) -> Floats:
    """Return by how much variances are enlarged, shape of both: 1 where chance explains chi2.

    Parameters
    ----------
    chi2, freedom
        Of a fit, and its degrees of freedom; without any the ratio is 1.
    """
    scatter, count = np.asarray(chi2, np.float64), np.maximum(freedom, 1)
    beyond = chance_of_more(scatter, freedom) < CONTRADICTED
    return np.where(beyond, np.maximum(scatter / count, 1.0), 1.0)
