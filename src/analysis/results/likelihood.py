"""The likelihood of measured impacts under Walton's law, every velocity with its error.

Of the four velocities of a shot the true approach and sliding speeds are unknown. A contact that
sticks ties them to what follows by two straight constraints, one that slides by two others:

    v_n' + e v_n = 0,    v_s' + beta0 v_s = 0                        (thesis, equation 7-1b)
    v_n' + e v_n = 0,    v_s' - v_s - mu (1 + e) (1 + 1/K) v_n = 0   (equation 7-1a, v_n negative)

so that r = A d with covariance A S A', and the true velocities are eliminated exactly: regression
with errors in all coordinates and their correlation. Nothing is divided by v_n: a glancing shot
counts as its errors let it. Which of the two holds is decided by the true v_s / |v_n| against
x_c = mu (1 + e) (1 + 1/K) / (1 + beta0), where the lines meet. A shot near it belongs to both, each
with the chance that its true place lies on that side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr

from analysis.arrays import Floats
from analysis.collision.operator import WaltonLaw
from analysis.effects.contact.tangential_compliance import friction_reach
from analysis.results.impacts import V_N, V_N_AFTER, V_S, V_S_AFTER, Impacts

LEAST_OPENING = 1e-3
"""Of the angle between the lines: at beta0 = -1 they are parallel."""
UNREACHED = -1e9
"""Logarithm of a chance that counts as none."""


@dataclass(frozen=True, slots=True, eq=False)
class Regime:
    """How S shots lie to one of the two regimes.

    Attributes
    ----------
    residual, sigma
        Of the surface velocity, v_s' less what the law makes of v_s and v_n, m/s, shape (S,).
    chi2
        Of both constraints, shape (S,).
    log_chance
        Logarithm of the chance that the true place lies where this regime holds, shape (S,).
    """

    residual: Floats
    sigma: Floats
    chi2: Floats
    log_chance: Floats

    @property
    def log_likelihood(self) -> Floats:
        """Return that of each shot, shape (S,)."""
        return np.asarray(-0.5 * self.chi2 + self.log_chance)


@dataclass(frozen=True, slots=True, eq=False)
class Likelihood:
    """Likelihood of S impacts under a law.

    Attributes
    ----------
    sticking, sliding
        The two regimes.
    normal_residual, normal_sigma
        v_n' + e v_n, m/s, shape (S,).
    chi2
        -2 log likelihood of each shot, shape (S,): chi-squared of the nearer regime, far from the
        transition.
    slides
        Probability that the shot slid, shape (S,); not a number without surface velocities.
    """

    sticking: Regime
    sliding: Regime
    normal_residual: Floats
    normal_sigma: Floats
    chi2: Floats
    slides: Floats


def transition(law: WaltonLaw, lever: float) -> float:
    """Return the v_s / |v_n| at which Walton's two lines meet."""
    return friction_reach(law, lever) / max(1 + law.beta0, LEAST_OPENING)


def likelihood(impacts: Impacts, law: WaltonLaw) -> Likelihood:
    """Hold impacts against a law."""
    measured, surface = impacts.velocities, impacts.surface
    normal = measured[:, V_N_AFTER] + law.e * measured[:, V_N]
    along = np.zeros(4)
    along[[V_N, V_N_AFTER]] = law.e, 1.0
    normal_sigma = np.sqrt(np.einsum("i,sij,j->s", along, impacts.covariance, along))
    corner = transition(law, impacts.lever)
    sticking = _regime(impacts, surface, law.e, (0.0, law.beta0), corner, sign=-1.0)
    reach = friction_reach(law, impacts.lever)
    sliding = _regime(impacts, surface, law.e, (-reach, -1.0), corner, sign=1.0)
    both = np.logaddexp(sticking.log_likelihood, sliding.log_likelihood)
    alone = (normal / normal_sigma) ** 2
    return Likelihood(
        sticking=sticking,
        sliding=sliding,
        normal_residual=normal,
        normal_sigma=normal_sigma,
        chi2=np.where(surface, -2 * both, alone),
        slides=np.where(surface, np.exp(sliding.log_likelihood - both), np.nan),
    )


def _regime(
    impacts: Impacts,
    surface: NDArray[np.bool_],
    e: float,
    line: tuple[float, float],
    corner: float,
    *,
    sign: float,
) -> Regime:
    """Hold impacts against v_n' + e v_n = 0 and v_s' + line . (v_n, v_s) = 0.

    Parameters
    ----------
    surface
        In which shots v_s and v_s' are measured, shape (S,).
    sign
        Of v_s + x_c v_n where the regime holds.
    """
    constraint = np.zeros((2, 4))
    constraint[0, [V_N, V_N_AFTER]] = e, 1.0
    constraint[1, [V_N, V_S, V_S_AFTER]] = *line, 1.0
    measured = np.where(surface[:, None], impacts.velocities, 0.0)
    carried = constraint @ impacts.covariance
    spread = carried @ constraint.T
    spread = np.where(surface[:, None, None], spread, np.eye(2))
    missed = (measured @ constraint.T)[..., None]
    pulled = np.linalg.solve(spread, missed)
    taken = np.linalg.solve(spread, carried)
    place = np.zeros(4)
    place[[V_N, V_S]] = corner, 1.0
    true = measured - (np.swapaxes(carried, 1, 2) @ pulled)[..., 0]
    left = impacts.covariance - np.swapaxes(carried, 1, 2) @ taken
    variance = np.einsum("i,sij,j->s", place, left, place)
    distance = sign * (true @ place) / np.sqrt(np.maximum(variance, 1e-30))
    chance = np.maximum(log_ndtr(distance), UNREACHED)
    return Regime(
        residual=missed[:, 1, 0],
        sigma=np.sqrt(spread[:, 1, 1]),
        chi2=np.maximum((missed * pulled).sum(axis=(1, 2)), 0.0),
        log_chance=chance,
    )
