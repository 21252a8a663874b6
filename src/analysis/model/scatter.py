"""Effects that are noise of their own: scored by the variance they add, not by a shift."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.effects.jitter_score import JitterScore, jitter_score
from analysis.model.comparison import compare, rates
from analysis.model.fit import Fit, parts_of
from analysis.model.jitter import by_frame
from analysis.model.normal import solve_blocks
from analysis.model.tables import ContactTable, Data

Floats = NDArray[np.float64]


def timing_jitter(data: Data, fit: Fit) -> JitterScore | None:
    """Test a fit for a time error that all numbers of a frame share; None: nothing could show.

    Each shot's own numbers are projected out; what all shots share takes too little to matter.
    """
    pieces = []
    for part, states in parts_of(data, fit.states):
        line, here = compare(part, states, fit.theory)
        if here.frames is None or isinstance(part, ContactTable):
            return None
        shots, blocks, _, size = line.slopes.shape
        own = line.slopes @ line.by_state.reshape(shots, blocks, size, -1)
        residual = by_frame(line.residual[..., None])
        pieces.append((residual, rates(part, here.frames.flown), by_frame(own)))
    residual, along, own = (np.concatenate(p) for p in zip(*pieces, strict=True))
    transposed = np.swapaxes(own, 1, 2)
    states_matrix = transposed @ own

    def project(columns: Floats) -> Floats:
        return np.asarray(columns - own @ solve_blocks(states_matrix, transposed @ columns))

    try:
        return jitter_score(residual.reshape(along.shape), along, project, fit.freedom)
    except ValueError:
        return None
