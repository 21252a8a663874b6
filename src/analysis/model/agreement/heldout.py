"""Parameters for each shot from the shots of the other folds."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.model.fitting.normal import with_prior
from analysis.model.rank.projector import Projector
from analysis.model.verdict.crossvalidation import FOLDS


def left_out_steps(sums: Projector, seed: int = 0) -> Floats:
    """Return how far the shared parameters lie without each shot's fold, shape (S, P).

    One Newton step from those of all shots, with the folds of `prediction_error`. Without other
    shots they stay.
    """
    shared, residual = sums.shared, sums.residual
    matrix = np.einsum("snp,snq->spq", shared, shared)
    gradient = np.einsum("snp,sn->sp", shared, residual)
    shots, (pull, held) = len(matrix), sums.held
    folds = np.random.default_rng(seed).permutation(shots) % min(FOLDS, shots)
    steps: Floats = np.zeros_like(gradient)
    for fold in np.unique(folds):
        others = folds != fold
        information = with_prior(matrix[others].sum(axis=0), held)
        downhill = gradient[others].sum(axis=0) + pull
        step = np.linalg.lstsq(information, downhill, rcond=1e-12)[0]
        steps[~others] = step
    return steps
