"""Impacts drawn from Walton's two lines in scalars, with correlated errors of known covariance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.results.impacts import Impacts

Floats = NDArray[np.float64]

LAW = (0.74, 0.08, 0.69)
LEVER = 3.5
"""1 + 1/K of solid spheres, K = 2/5."""
CORNER = 3.5 * 0.08 * 1.74 / 1.69


def impacts(
    rng: np.random.Generator,
    incidence: Floats,
    *,
    law: tuple[float, float, float] = LAW,
    noise: float = 0.01,
    approach: Floats | None = None,
) -> Impacts:
    """Return one impact for each v_s / |v_n|, errors about `noise` m/s."""
    e, mu, beta0 = law
    shots = len(incidence)
    v_n = rng.uniform(0.5, 5.0, shots) if approach is None else approach
    v_s = v_n * incidence
    after = np.maximum(-beta0 * v_s, v_s - LEVER * mu * (1 + e) * v_n)
    true = np.stack([-v_n, v_s, e * v_n, after], axis=1)
    mixed = rng.normal(0, noise / 2, (shots, 4, 4))
    covariance = mixed @ mixed.transpose(0, 2, 1) + np.eye(4) * (noise / 3) ** 2
    root = np.linalg.cholesky(covariance)
    measured = true + (root @ rng.normal(size=(shots, 4, 1)))[..., 0]
    # v_s is a length: what falls below zero is seen along the other direction.
    sign = np.where(measured[:, 1] < 0, -1.0, 1.0)
    turn = np.stack([np.ones(shots), sign, np.ones(shots), sign], axis=1)
    return Impacts(
        np.arange(1, shots + 1),
        measured * turn,
        covariance * turn[:, :, None] * turn[:, None, :],
        LEVER,
    )


def both_regimes(rng: np.random.Generator, shots: int) -> Floats:
    """Return v_s / |v_n|: half of the shots stick, half slide, some near where the lines meet."""
    stick, slide = rng.uniform(0.02, CORNER, shots // 2), rng.uniform(CORNER, 6, shots - shots // 2)
    return np.concatenate([stick, slide])
