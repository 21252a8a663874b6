"""The laws in the plane of figure 7.4: Walton's two lines, and Maw, Barber and Fawcett's curve."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import WaltonLaw
from analysis.effects.contact.spring_slider import rebound
from analysis.effects.contact.tangential_compliance import STIFFNESS_RATIO
from analysis.results.likelihood import friction_reach
from analysis.results.lines import Lines

POISSON_RATIO = (2 - 2 * STIFFNESS_RATIO) / (2 - STIFFNESS_RATIO)
"""Of Maw's curve as it is drawn."""


def walton_curve(law: WaltonLaw, lever: float, x: Floats) -> Floats:
    """Return v_s' / |v_n| of equations (7-1) at v_s / |v_n|."""
    return np.asarray(np.maximum(-law.beta0 * x, x - friction_reach(law, lever)))


def regression_curve(found: Lines, lever: float, x: Floats) -> Floats:
    """Return the same of a regression, with the lines alone that its shots determine."""
    if "mu" not in found.fitted:
        return np.asarray(
            -found.law.beta0 * x if "beta0" in found.fitted else np.full_like(x, np.nan)
        )
    if "beta0" not in found.fitted:
        return np.asarray(x - friction_reach(found.law, lever))
    return walton_curve(found.law, lever, x)


def maw_curve(e: float, mu: float, lever: float, x: Floats) -> Floats:
    """Return v_s' / |v_n| of compliant spheres (N. Maw et al., Wear 38, 101 (1976)), same e and mu.

    Not a number without friction.
    """
    if not mu > 0:
        return np.full_like(x, np.nan)
    unit = mu / STIFFNESS_RATIO
    return np.asarray(unit * rebound(x / unit, STIFFNESS_RATIO * lever / 2, np.full_like(x, e)))
