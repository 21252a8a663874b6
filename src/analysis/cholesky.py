"""Small positive definite systems inside compiled functions (A. L. Cholesky)."""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import part

SINGULAR = 1e-13
"""Share of a diagonal element that must be left: else its direction is open."""


@part
def gram(rows: Floats, weight: Floats, products: Floats) -> None:
    """Fill the lower triangle of the weighted products of rows, sum_k w_k rows_ak rows_bk.

    With residuals in the last row these are normal equations: matrix, right side below it, and the
    sum of squares in the last corner.

    Parameters
    ----------
    rows
        Shape (rows, points).
    weight
        Shape (points,).
    products
        Shape (rows, rows).
    """
    weighted = np.empty(weight.size)
    for a in range(rows.shape[0]):
        own = rows[a]
        for k in range(weight.size):
            weighted[k] = weight[k] * own[k]
        for b in range(a + 1):
            total, other = 0.0, rows[b]
            for k in range(weight.size):
                total += weighted[k] * other[k]
            products[a, b] = total


@part
def factor(normal: Floats, size: int) -> bool:
    """Put a positive definite matrix's Cholesky root in its lower triangle; false where it is not.

    Only the first `size` rows and columns take part.
    """
    for a in range(size):
        for b in range(a + 1):
            left = normal[a, b]
            for k in range(b):
                left -= normal[a, k] * normal[b, k]
            if a != b:
                normal[a, b] = left / normal[b, b]
            elif left > SINGULAR * normal[a, a]:
                normal[a, a] = math.sqrt(left)
            else:
                return False
    return True


@part
def solve(root: Floats, size: int, right: Floats) -> None:
    """Replace the right side by the solution of the equations that `factor` has prepared."""
    for a in range(size):
        for k in range(a):
            right[a] -= root[a, k] * right[k]
        right[a] /= root[a, a]
    for a in range(size - 1, -1, -1):
        for k in range(a + 1, size):
            right[a] -= root[k, a] * right[k]
        right[a] /= root[a, a]
