"""Each shot's own equations: small, positive definite, many right sides (A. L. Cholesky)."""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import compiled, part

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
        rows = result[s]
        _forward(root, scale, right[s], rows)
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


@compiled
def whitened(variances: Floats, columns: Floats) -> Floats:
    """Return L^-1 b of each shot, L L' its covariance: columns in units of independent errors.

    Parameters
    ----------
    variances, columns
        Shapes (S, N, N) and (S, N, K).

    Returns
    -------
    Shape (S, N, K).
    """
    shots, size, _ = columns.shape
    result = np.empty(columns.shape)
    root, scale = np.empty((size, size)), np.empty(size)
    for s in range(shots):
        _factor(variances[s], 0.0, root, scale)
        _forward(root, scale, columns[s], result[s])
    return result


@compiled
def information(moved: Floats, gram: Floats) -> Floats:
    """Return B' G B of each shot, B what N numbers do to P others that squares G depend on.

    Most of B and half of G are zero, and are passed over.

    Parameters
    ----------
    moved
        B, shape (S, P, N).
    gram
        G, block by block, shape (S, blocks, P / blocks, P / blocks).

    Returns
    -------
    Shape (S, N, N).
    """
    shots, _, count = moved.shape
    blocks, size = gram.shape[1], gram.shape[2]
    result, weighed = np.zeros((shots, count, count)), np.empty(count)
    for s in range(shots):
        for block in range(blocks):
            rows = moved[s, block * size : (block + 1) * size]
            for p in range(size):
                weighed[:] = 0.0
                for q in range(size):
                    share = gram[s, block, p, q]
                    if share != 0.0:
                        for k in range(count):
                            weighed[k] += share * rows[q, k]
                for a in range(count):
                    share = rows[p, a]
                    if share != 0.0:
                        for k in range(count):
                            result[s, a, k] += share * weighed[k]
    return result


@compiled
def whitenings(gram: Floats, least: float) -> Floats:
    """Return what takes columns to unit columns across each other, one block after another.

    T with T' G T = 1, and zero in the place of a column that those before it can make.

    Parameters
    ----------
    gram
        G, the columns' products, shape (S, blocks, P, P).
    least
        A column of which no larger share of its square is left is made by the others.

    Returns
    -------
    T, shape (S, blocks, P, P): upper triangles.
    """
    shots, blocks, size, _ = gram.shape
    result = np.zeros(gram.shape)
    root, scale = np.zeros((size, size)), np.empty(size)
    for s in range(shots):
        for block in range(blocks):
            product, white = gram[s, block], result[s, block]
            for a in range(size):
                scale[a] = math.sqrt(max(product[a, a], least))
            for a in range(size):
                left = product[a, a] / scale[a] / scale[a]
                for b in range(a):
                    rest = product[a, b] / scale[a] / scale[b]
                    for k in range(b):
                        rest -= root[a, k] * root[b, k]
                    root[a, b] = rest * root[b, b]
                    left -= root[a, b] * root[a, b]
                # The diagonal holds one over the root's, zero for a column that is dropped.
                root[a, a] = 1.0 / math.sqrt(left) if left > least else 0.0
                for b in range(a):
                    rest = 0.0
                    for k in range(b, a):
                        rest -= root[a, k] * white[b, k] * scale[b]
                    white[b, a] = rest * root[a, a] / scale[b]
                white[a, a] = root[a, a] / scale[a]
    return result


@part
def _forward(root: Floats, scale: Floats, given: Floats, rows: Floats) -> None:
    """Fill rows with what the root of a scaled matrix makes the given ones of."""
    size, count = given.shape
    for a in range(size):
        for k in range(count):
            rows[a, k] = given[a, k] / scale[a]
        for b in range(a):
            share = root[a, b]
            for k in range(count):
                rows[a, k] -= share * rows[b, k]
        for k in range(count):
            rows[a, k] /= root[a, a]


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
