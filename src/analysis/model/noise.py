"""How large the noise really is, positions and orientations apart."""

from __future__ import annotations

import numpy as np

from analysis.model.fit import Fit
from analysis.model.linear import linearise
from analysis.model.normal import solve_blocks
from analysis.model.poses import PoseData


def noise_scales(data: PoseData, fit: Fit) -> tuple[float, float]:
    """Return by what to multiply the stated sigmas of positions and of orientations.

    Chi-squared of each kind over its share of the degrees of freedom: its residuals less its part
    of what each shot's own numbers took up (the trace of its block of the hat matrix).
    """
    line = linearise(data, fit.states, fit.theory)
    by_state = np.swapaxes(line.by_state, 1, 2)
    whole = by_state @ line.by_state
    kinds = np.tile(np.repeat([0, 1], 3), line.residual.shape[1] // 6)
    measured = data.measured.reshape(len(data.shots), -1)
    scales = []
    for kind in (0, 1):
        own = kinds == kind
        part = by_state[:, :, own] @ line.by_state[:, own]
        taken = float(np.trace(solve_blocks(whole, part), axis1=1, axis2=2).sum())
        freedom = float(measured[:, own].sum()) - taken
        squares = float((line.residual[:, own] ** 2).sum())
        scales.append(float(np.sqrt(squares / freedom)) if freedom > 0 else 1.0)
    return scales[0], scales[1]


def rescaled(data: PoseData, fit: Fit) -> PoseData:
    """Return the data with sigmas as large as the residuals of a fit say they are."""
    position, rotation = noise_scales(data, fit)
    return data.with_sigmas(position * data.position_sigma, rotation * data.rotation_sigma)
