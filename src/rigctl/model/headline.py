"""The first lines on a fit, as the commands and the Python interface print them."""

from __future__ import annotations

import math

from analysis.model.fitting.account import Accounted
from analysis.model.fitting.nuisance import alarms_of
from analysis.model.fitting.nuisance_words import alarm_sentences


def headline(title: str, found: Accounted) -> str:
    """Say what was fitted, how well, and what was left out."""
    fit = found.fit
    shots = len(fit.shot_chi2)
    first = (
        f"{title}: {shots} shots, chi-squared per degree of freedom {fit.chi2_per_dof:.4f} "
        f"(sampling error {math.sqrt(2 / max(fit.freedom, 1)):.4f})"
    )
    alarms = alarm_sentences(alarms_of(fit))
    return "\n".join([first, *found.account.remarks(), *alarms])
