"""Prediction error on shots left out, poses after contact from the poses before alone.

Whitened with everything the state before contact does not know, its floor is 1. By Woodbury
r' S^-1 r = chi2(all frames) - chi2(frames before), each minimised over the shot's own numbers, so
no shot is fitted again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.fit import Fit, normal_equations
from analysis.model.fitting.normal import NormalEquations, solve_blocks, with_prior

Floats = NDArray[np.float64]

FOLDS = 5


@dataclass(frozen=True, slots=True, eq=False)
class PredictionError:
    """Whitened error on shots left out.

    Attributes
    ----------
    value
        Root of the mean squared whitened error; 1 is the floor set by the measurement's noise.
    sampling
        Its standard deviation when nothing is missing.
    by_shot
        Whitened squares of each shot left out, shape (S,).
    """

    value: float
    sampling: float
    by_shot: Floats


def prediction_error(
    data: Data, fit: Fit, seed: int = 0, folds: NDArray[np.intp] | None = None
) -> PredictionError:
    """Predict each fifth of the shots with the parameters of the other four.

    The parameters without a fold are one Newton step from those of all shots.

    Parameters
    ----------
    folds
        Number of the fold that each shot is left out with, shape (S,); None: fifths by chance.
    """
    known, count = _known_before(data, fit)
    whole = normal_equations(data, fit.states, fit.theory)
    early = normal_equations(known, fit.states, fit.theory)
    matrix, gradient = whole.reduced_by_shot()
    early_matrix, early_gradient = early.reduced_by_shot()
    least, early_least = _least(whole), _least(early)
    if folds is None:
        folds = np.random.default_rng(seed).permutation(len(least)) % min(FOLDS, len(least))
    pull, held = fit.theory.held
    squares = np.zeros(len(least))
    for fold in np.unique(folds):
        own, others = folds == fold, folds != fold
        information = with_prior(matrix[others].sum(axis=0), held)
        downhill = gradient[others].sum(axis=0) + pull
        step = np.linalg.lstsq(information, downhill, rcond=1e-12)[0]
        squares[own] = _moved(least, gradient, matrix, own, step)
        squares[own] -= _moved(early_least, early_gradient, early_matrix, own, step)
    value = np.sqrt(max(float(squares.sum()), 0.0) / max(count, 1))
    return PredictionError(float(value), float(np.sqrt(0.5 / max(count, 1))), squares)


def _known_before(data: Data, fit: Fit) -> tuple[Data, int]:
    """Return the data without what was measured after contact, and how much that was."""
    if isinstance(data, ContactTable):
        return data.before(), int(data.measured[:, data.after].sum())
    after = data.times_s > fit.states.time_s[:, None]
    return data.without(after), int((data.measured & after[:, :, None, None]).sum())


def _least(sums: NormalEquations) -> Floats:
    """Return chi-squared of each shot minimised over its own numbers, shape (S,)."""
    step = solve_blocks(sums.states, sums.state_gradient[..., None])[..., 0]
    return np.asarray(sums.chi2 - (sums.state_gradient * step).sum(axis=1))


def _moved(
    least: Floats, gradient: Floats, matrix: Floats, own: NDArray[np.bool_], step: Floats
) -> Floats:
    """Return chi-squared of some shots at parameters a step away, shape (shots,)."""
    linear = gradient[own] @ step
    square = np.einsum("i,sij,j->s", step, matrix[own], step)
    return np.asarray(least[own] - 2 * linear + square)
