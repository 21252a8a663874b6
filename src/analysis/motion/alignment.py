"""The rotation that takes some directions to others, by least squares (thesis, section 5.2)."""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import compiled, part

MOST_SWEEPS = 30
NEGLIGIBLE = 1e-9
"""Share of the largest element off the diagonal before a sweep that is the last: what it leaves is
about the square of that."""


def rotation_from_directions(
    before: Floats, after: Floats, weights: Floats | None = None
) -> Floats:
    """Return the rotation R that takes `before` to `after`, by least squares over rotations.

    Minimises sum_i w_i |after_i - R before_i|^2 with R orthogonal (W. Kabsch, Acta Cryst. A 34,
    827-828 (1978), doi:10.1107/S0567739478001680), in the form of B. K. P. Horn, J. Opt. Soc.
    Am. A 4, 629-642 (1987), doi:10.1364/JOSAA.4.000629: the unit quaternion that belongs to the
    largest eigenvalue of a symmetric 4 x 4 matrix. Three directions not in one plane, or two not
    along one line, are needed.

    Parameters
    ----------
    before, after
        Unit vectors, shape (markers, 3).
    weights
        Shape (markers,); None: all alike.

    Returns
    -------
    Shape (3, 3).
    """
    return aligned(before, after, np.ones(len(before)) if weights is None else weights)


@compiled
def aligned(before: Floats, after: Floats, weights: Floats) -> Floats:
    """Return the rotation of `rotation_from_directions`."""
    s = np.zeros((3, 3))
    for n in range(before.shape[0]):
        for a in range(3):
            for b in range(3):
                s[a, b] += weights[n] * before[n, a] * after[n, b]
    return turn_of(s)


@part
def turn_of(s: Floats) -> Floats:
    """Return the rotation of the sums of w before after', shape (3, 3)."""
    form = np.zeros((4, 4))
    form[0, 0] = s[0, 0] + s[1, 1] + s[2, 2]
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        form[0, k + 1] = s[i, j] - s[j, i]
        form[k + 1, 0] = form[0, k + 1]
        form[k + 1, k + 1] = s[k, k] - s[i, i] - s[j, j]
        form[i + 1, j + 1] = s[i, j] + s[j, i]
        form[j + 1, i + 1] = form[i + 1, j + 1]
    vectors = np.eye(4)
    diagonalise(form, vectors)
    best = 0
    for k in range(1, 4):
        if form[k, k] > form[best, best]:
            best = k
    w, x, y, z = vectors[0, best], vectors[1, best], vectors[2, best], vectors[3, best]
    rotation = np.empty((3, 3))
    rotation[0, 0], rotation[0, 1] = w * w + x * x - y * y - z * z, 2 * (x * y - w * z)
    rotation[0, 2], rotation[1, 0] = 2 * (x * z + w * y), 2 * (x * y + w * z)
    rotation[1, 1], rotation[1, 2] = w * w - x * x + y * y - z * z, 2 * (y * z - w * x)
    rotation[2, 0], rotation[2, 1] = 2 * (x * z - w * y), 2 * (y * z + w * x)
    rotation[2, 2] = w * w - x * x - y * y + z * z
    return rotation


@part
def diagonalise(form: Floats, vectors: Floats) -> None:
    """Turn a symmetric matrix to its axes, in place (C. G. J. Jacobi, J. reine angew. Math. 30).

    Parameters
    ----------
    vectors
        The unit matrix; filled with the axes, in columns.
    """
    size, largest = form.shape[0], np.abs(form).max()
    for _ in range(MOST_SWEEPS):
        left = 0.0
        for p in range(size):
            for q in range(p + 1, size):
                left = max(left, abs(form[p, q]))
                if form[p, q] == 0.0:
                    continue
                ratio = (form[q, q] - form[p, p]) / (2.0 * form[p, q])
                t = 1.0 / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
                t = t if ratio >= 0.0 else -t
                c = 1.0 / math.sqrt(1.0 + t * t)
                turn_pair(form, vectors, (p, q), (c, t * c))
        if left <= NEGLIGIBLE * largest:
            break


@part
def turn_pair(
    form: Floats, vectors: Floats, axes: tuple[int, int], turn: tuple[float, float]
) -> None:
    """Turn two axes of a symmetric matrix and of its vectors by an angle (cosine, sine)."""
    p, q = axes
    c, s = turn
    for k in range(form.shape[0]):
        a, b = form[k, p], form[k, q]
        form[k, p], form[k, q] = c * a - s * b, s * a + c * b
    for k in range(form.shape[0]):
        a, b = form[p, k], form[q, k]
        form[p, k], form[q, k] = c * a - s * b, s * a + c * b
    for k in range(form.shape[0]):
        a, b = vectors[k, p], vectors[k, q]
        vectors[k, p], vectors[k, q] = c * a - s * b, s * a + c * b
