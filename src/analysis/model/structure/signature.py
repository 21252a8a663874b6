"""Where an effect shows: what it does to the residuals, held against the cells of lack of fit.

An effect that is really there leaves nothing in the cells where it shows most. One that only stands
for something else mends these in part, and what it leaves stays there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.fitting.normal import inverse, with_prior
from analysis.model.predict.theory import Theory
from analysis.model.rank.projector import ColumnSums
from analysis.model.structure.summing import Name, Summed

OWN_CELLS = 4
"""So many cells are an effect's own: few, so that little is paid for looking."""


def own_cells(theory: Theory, sums: Summed) -> Mapping[str, list[Name]]:
    """Return in which cells each effect of a fit shows most, by its name."""
    chosen: dict[str, list[Name]] = {}
    start = theory.given
    for active in theory.active:
        stop = start + len(active.values)
        shown = _shown(sums, np.arange(start, stop), active.values - active.effect.off)
        chosen[active.effect.name] = sorted(shown, key=lambda name: -shown[name])[:OWN_CELLS]
        start = stop
    return chosen


def _shown(sums: Summed, own: NDArray[np.intp], shift: Floats) -> dict[Name, float]:
    """Return the fall that each cell would bring in a fit without an effect, free of noise.

    What is left there is what the effect does, less what the other parameters can imitate.

    Parameters
    ----------
    own
        Where the effect's parameters stand among the shared ones, shape (B,).
    shift
        Their values, less those where the effect is off, shape (B,).
    """
    others = np.setdiff1d(np.arange(len(sums.known)), own)
    known, information = sums.known[others], sums.information[np.ix_(others, others)]
    covariance = inverse(with_prior(information, known))
    imitated = covariance @ (sums.information[np.ix_(others, own)] @ shift)

    def without(cell: ColumnSums) -> ColumnSums:
        left = cell.against[:, others]
        return replace(cell, against=left, gradient=cell.against[:, own] @ shift - left @ imitated)

    nothing = np.zeros(len(others))
    return {
        name: without(cell).solved(covariance, nothing).chi2 for name, cell in sums.cells.items()
    }
