"""Prediction error on shots left out, poses after contact from the poses before alone.

Whitened with everything the state before contact does not know, its floor is 1. By Woodbury
r' S^-1 r = chi2(all frames) - chi2(frames before), each minimised over the shot's own numbers, so
no shot is fitted again.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.fit import Fit, parts_of
from analysis.model.fitting.gauss_newton import summed
from analysis.model.fitting.normal import NormalEquations, solve_blocks, with_prior
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

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


@dataclass(frozen=True, slots=True, eq=False)
class _Gap:
    """Chi-squared of all frames less that of the frames before, of S shots about a fit.

    Each minimised over the shot's own numbers: its value (S,), half its slope downhill (S, P) and
    half its curvature (S, P, P) by the shared parameters.
    """

    value: Floats
    downhill: Floats
    matrix: Floats

    def at(self, steps: Floats) -> Floats:
        """Return it at parameters a step away, steps of shape (S, P)."""
        linear = (self.downhill * steps).sum(axis=1)
        square = ((self.matrix @ steps[..., None])[..., 0] * steps).sum(axis=1)
        return np.asarray(self.value - 2 * linear + square)


def prediction_error(
    data: CampaignData, fit: Fit, seed: int = 0, folds: NDArray[np.intp] | None = None
) -> PredictionError:
    """Predict each fifth of the shots with the parameters of the other four.

    The parameters without a fold are one Newton step from those of all shots.

    Parameters
    ----------
    folds
        Number of the fold that each shot is left out with, shape (S,); None: fifths by chance.
    """
    if folds is None:
        folds = folds_by_chance(len(data.shots), seed)
    [error] = prediction_errors(data, fit, (folds,))
    return error


def folds_by_chance(shots: int, seed: int = 0) -> NDArray[np.intp]:
    """Return the fifth that each shot is in, drawn, shape (S,)."""
    return np.random.default_rng(seed).permutation(shots) % min(FOLDS, shots)


def prediction_errors(
    data: CampaignData, fit: Fit, foldings: Sequence[NDArray[np.intp]]
) -> list[PredictionError]:
    """Return the error on shots left out in several ways, in one pass over the shots.

    Parameters
    ----------
    foldings
        Each the number of the fold that each shot is left out with, shape (S,).
    """
    folded = [_Folded.of(folds, len(fit.theory.vector)) for folds in foldings]
    gaps, count, start = data.keep(_Gap), 0, 0
    for part, states in parts_of(data, fit):
        known, after = _known_before(part, states)
        whole, gap = _gap(part, known, states, fit.theory)
        for one in folded:
            one.add(slice(start, start + part.count), whole)
        gaps.append(gap)
        count, start = count + after, start + part.count
    return [_error(one, gaps, count, fit.theory) for one in folded]


@dataclass(frozen=True, slots=True, eq=False)
class _Folded:
    """Sums of M and g of each fold: its number for each shot (S,), (K, P, P), (K, P)."""

    folds: NDArray[np.intp]
    matrix: Floats
    downhill: Floats

    @classmethod
    def of(cls, folds: NDArray[np.intp], size: int) -> _Folded:
        """Return empty sums."""
        _, numbers = np.unique(folds, return_inverse=True)
        count = int(numbers.max()) + 1
        return cls(numbers, np.zeros((count, size, size)), np.zeros((count, size)))

    def add(self, shots: slice, sums: tuple[Floats, Floats]) -> None:
        """Add M and g of some shots."""
        np.add.at(self.matrix, self.folds[shots], sums[0])
        np.add.at(self.downhill, self.folds[shots], sums[1])


def _error(folded: _Folded, gaps: Iterable[_Gap], count: int, theory: Theory) -> PredictionError:
    """Return the error of shots left out fold by fold, `count` numbers after contact in all."""
    steps, start = _steps_without(folded.matrix, folded.downhill, theory), 0
    squares = np.zeros(len(folded.folds))
    for gap in gaps:
        own = slice(start, start := start + len(gap.value))
        squares[own] = gap.at(steps[folded.folds[own]])
    value = np.sqrt(max(float(squares.sum()), 0.0) / max(count, 1))
    return PredictionError(float(value), float(np.sqrt(0.5 / max(count, 1))), squares)


def _steps_without(matrix: Floats, downhill: Floats, theory: Theory) -> Floats:
    """Return the step of the parameters without each fold, from sums by fold, shape (folds, P)."""
    pull, held = theory.held
    return np.array(
        [
            np.linalg.lstsq(
                with_prior(np.delete(matrix, fold, axis=0).sum(axis=0), held),
                np.delete(downhill, fold, axis=0).sum(axis=0) + pull,
                rcond=1e-12,
            )[0]
            for fold in range(len(matrix))
        ]
    )


def _gap(
    data: Data, known: Data, states: ShotStates, theory: Theory
) -> tuple[tuple[Floats, Floats], _Gap]:
    """Return what each shot of a part adds to M and g, and the gap to what was known before."""
    whole, early = (summed(one, states, theory)[1] for one in (data, known))
    (matrix, downhill), (early_matrix, early_downhill) = (
        sums.reduced_by_shot() for sums in (whole, early)
    )
    gap = _Gap(_least(whole) - _least(early), downhill - early_downhill, matrix - early_matrix)
    return (matrix, downhill), gap


def _known_before(data: Data, states: ShotStates) -> tuple[Data, int]:
    """Return the data without what was measured after contact, and how much that was."""
    if isinstance(data, ContactTable):
        return data.before(), int(data.measured[:, data.after].sum())
    after = data.times_s > states.time_s[:, None]
    return data.without(after), int((data.measured & after[:, :, None, None]).sum())


def _least(sums: NormalEquations) -> Floats:
    """Return chi-squared of each shot minimised over its own numbers, shape (S,)."""
    step = solve_blocks(sums.states, sums.state_gradient[..., None])[..., 0]
    return np.asarray(sums.chi2 - (sums.state_gradient * step).sum(axis=1))
