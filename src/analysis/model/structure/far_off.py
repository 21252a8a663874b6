"""When a whole chi-squared is larger than chance makes it, whatever cell it may stand in."""

from __future__ import annotations

import numpy as np

from analysis import chi_squared
from analysis.model.fitting.summary import FitSummary
from analysis.model.structure.alarm import FEWEST

FAR_OFF = 1e-4
"""Chance of a chi-squared below which it is not believed to be noise of the stated size.

That of four standard deviations, as far as stated sigmas may be from the scatter before they are
corrected.
"""
LOUDEST = 2


def is_far_off(fit: FitSummary) -> bool:
    """Tell whether a fit leaves more than noise, and not in two of its shots alone."""
    own = fit.shot_residuals - fit.nuisance_count
    if len(own) < FEWEST or fit.p_chi2 > FAR_OFF:
        return False
    loudest = np.argsort(fit.shot_chi2 - own)[-LOUDEST:]
    chi2 = fit.chi2 - (fit.by_field or 0.0) - float(fit.shot_chi2[loudest].sum())
    return bool(chi_squared.chance_of_more(chi2, fit.freedom - int(own[loudest].sum())) < FAR_OFF)
