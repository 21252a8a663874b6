"""Every shot fitted by itself: where a campaign's fit begins.

Levenberg-Marquardt, damped shot by shot, so that one in trouble does not slow the others.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.tables import Data
from analysis.model.fitting.normal import NormalEquations, shot_steps, sums_of
from analysis.model.predict.columns import no_columns
from analysis.model.predict.comparison import compare
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

SHOT_ROUNDS, SHOT_ITERATIONS, MOST = 4, 4, 0.75
"""A round ends where most shots are at rest, and the next goes on with the others."""
ROUGHLY = 0.5
"""Of chi-squared of a shot by itself: what all shots share is to come."""


def own_states(data: Data, states: ShotStates, theory: Theory) -> ShotStates:
    """Fit the own numbers of each shot of one part at a fixed theory, from where they stand."""
    left = np.ones(len(states.time_s), dtype=np.bool_)
    for _ in range(SHOT_ROUNDS):
        own, done = _fit_some(data.of_shots(left), states.of_shots(left), theory)
        states = states.replaced(left, own)
        left[left] = ~done
        if not left.any():
            break
    return states


def _fit_some(
    data: Data, states: ShotStates, theory: Theory
) -> tuple[ShotStates, NDArray[np.bool_]]:
    """Take a few damped steps with every shot; return their states, and which are done, (S,).

    A shot is done whose step changed little, or that came down and whose next has a small expected
    drop.
    """
    damping = np.full(len(states.time_s), 1e-3)
    sums = _own_equations(data, states, theory)
    step = shot_steps(sums, damping)
    done = np.zeros(len(damping), dtype=np.bool_)
    for _ in range(SHOT_ITERATIONS):
        new = states.moved(step)
        tried = _own_equations(data, new, theory)
        better = tried.chi2 < sums.chi2
        done = np.abs(sums.chi2 - tried.chi2) < ROUGHLY
        states, sums = states.chosen(new, better), sums.chosen(tried, better)
        damping = np.clip(np.where(better, damping * 0.1, damping * 10.0), 1e-12, 1e6)
        step = shot_steps(sums, damping)
        done |= better & ((sums.state_gradient * step).sum(axis=1) < ROUGHLY)
        if done.mean() >= MOST:
            break
    return states, done


def _own_equations(data: Data, states: ShotStates, theory: Theory) -> NormalEquations:
    line, _ = compare(data, states, theory)
    return sums_of(line, no_columns(line))
