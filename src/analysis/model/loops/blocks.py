"""Each shot's own equations: small, positive definite, many right sides (A. L. Cholesky)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part

Floats = NDArray[np.float64]

RIDGE = 1e-10
"""Added to the unit diagonal, so that it is positive definite."""
LEAST_SQUARE = 1e-13
"""Of what is left of a diagonal element: rounding is far below RIDGE."""
NOTHING = 1e-300


@compiled
def solved(matrices: Floats, right: Floats, damping: Floats) -> Floats:
    """Solve (A + damping diag A) x = b of each shot, scaled to a unit diagonal.

    Numbers without information stay put.

    Parameters
    ----------
    matrices, right
        Shapes (S, N, N) and (S, N, K).
    damping
        Shape (S,).

    Returns
    -------
    Shape (S, N, K).
    """
    shots, size, count = right.shape
    result = np.empty(right.shape)
    root, scale = np.empty((size, size)), np.empty(size)
    for s in range(shots):
        _factor(matrices[s], damping[s], root, scale)
        rows, given = result[s], right[s]
        for a in range(size):
            for k in range(count):
                rows[a, k] = given[a, k] / scale[a]
            for b in range(a):
                share = root[a, b]
                for k in range(count):
                    rows[a, k] -= share * rows[b, k]
            for k in range(count):
                rows[a, k] /= root[a, a]
        for a in range(size - 1, -1, -1):
            for k in range(count):
                rows[a, k] /= root[a, a]
            for b in range(a):
                share = root[a, b]
                for k in range(count):
                    rows[b, k] -= share * rows[a, k]
            for k in range(count):
                rows[a, k] /= scale[a]
    return result


@part
def _factor(matrix: Floats, damping: float, root: Floats, scale: Floats) -> None:
    """Fill the lower triangle of the root of a scaled matrix, and the scale of each number."""
    size = scale.size
    for a in range(size):
        scale[a] = math.sqrt(max(matrix[a, a], NOTHING))
    for a in range(size):
        for b in range(a):
            left = matrix[a, b] / scale[a] / scale[b]
            for k in range(b):
                left -= root[a, k] * root[b, k]
            root[a, b] = left / root[b, b]
        own = matrix[a, a] * (1.0 + damping) / scale[a] / scale[a]
        left = max(own, 1.0) + RIDGE
        for k in range(a):
            left -= root[a, k] * root[a, k]
        root[a, a] = math.sqrt(max(left, LEAST_SQUARE))
