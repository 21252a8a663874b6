"""Where an effect shows: what it does to the residuals, held against the cells of lack of fit.

An effect that is really there leaves nothing in the cells where it shows most. One that only stands
for something else mends these in part, and what it leaves stays there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.normal import inverse, solve_blocks, with_prior
from analysis.model.predict.linear import Linearised, linearise
from analysis.model.predict.theory import Theory
from analysis.model.rank.projector import Projector, Solved

Floats = NDArray[np.float64]
Falls = Callable[[Projector], list[tuple[str, str, Solved]]]
"""From a linearised fit to the channel, covariate and solution of every cell, always in order."""

OWN_CELLS = 4
"""So many cells are an effect's own: few, so that little is paid for looking."""


def own_cells(data: Data, fit: Fit, sums: Projector, falls: Falls) -> dict[str, NDArray[np.intp]]:
    """Return in which cells each effect of a fit shows most, by its name."""
    chosen: dict[str, NDArray[np.intp]] = {}
    if not fit.theory.active:
        return chosen
    line = linearise(data, fit.states, fit.theory)
    start = fit.theory.given
    for active in fit.theory.active:
        stop = start + len(active.values)
        shift = active.values - active.effect.off
        alone = _only(line, sums, fit.theory, np.arange(start, stop), shift)
        shown = np.array([solved.chi2 for *_, solved in falls(alone)])
        chosen[active.effect.name] = np.argsort(shown)[::-1][:OWN_CELLS]
        start = stop
    return chosen


def _only(
    line: Linearised, sums: Projector, theory: Theory, own: NDArray[np.intp], shift: Floats
) -> Projector:
    """Return a fit without an effect whose residuals are what the effect does, free of noise.

    Parameters
    ----------
    own
        Where the effect's parameters stand among the shared ones, shape (B,).
    shift
        Their values, less those where the effect is off, shape (B,).
    """
    others = np.setdiff1d(np.arange(sums.shared.shape[2]), own)
    shared, raw = sums.shared[..., others], line.by_theory[..., others]
    known = theory.prior[1][others]
    covariance = inverse(with_prior(np.einsum("snp,snq->pq", raw, shared), known))
    done = line.by_theory[..., own] @ shift
    taken = np.swapaxes(sums.by_state, 1, 2) @ done[..., None]
    done = done - (sums.by_state @ solve_blocks(sums.states, taken))[..., 0]
    done = done - shared @ (covariance @ np.einsum("snp,sn->p", shared, done))
    return replace(
        sums,
        residual=done,
        own_gradient=np.zeros_like(sums.own_gradient),
        shared=shared,
        covariance=covariance,
        held=(sums.held[0][others], sums.held[1][others]),
        left=np.zeros(len(others)),
    )
