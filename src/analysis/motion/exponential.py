"""The exponential map of rotations and its derivative, for many vectors at once."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats

_SMALL = 1e-4
"""rad; below it the series are exact to double precision."""


def exponential(vector: Floats) -> tuple[Floats, Floats]:
    """Return the rotations exp(v) and the left Jacobians d log(exp(v + dv) exp(-v)) / dv.

    G. S. Chirikjian, Stochastic Models, Information Theory, and Lie Groups 2 (2012), section 10.8.

    Parameters
    ----------
    vector
        Axis times angle, rad, shape (..., 3).

    Returns
    -------
    Both of shape (..., 3, 3).
    """
    square = (vector**2).sum(axis=-1)
    angle = np.sqrt(square)
    safe = np.maximum(angle, _SMALL)
    large = angle > _SMALL
    sine = np.where(large, np.sin(safe) / safe, 1 - square / 6)
    versine = np.where(large, (1 - np.cos(safe)) / safe**2, 0.5 - square / 24)
    third = np.where(large, (1 - sine) / safe**2, 1 / 6 - square / 120)
    outer = vector[..., :, None] * vector[..., None, :]
    return (
        _combined(vector, outer, (1 - versine * square, sine, versine)),
        _combined(vector, outer, (1 - third * square, versine, third)),
    )


def _combined(vector: Floats, outer: Floats, weights: tuple[Floats, Floats, Floats]) -> Floats:
    """Return w0 1 + w1 [v]x + w2 v v'."""
    matrix = weights[2][..., None, None] * outer
    index = np.arange(3)
    matrix[..., index, index] += weights[0][..., None]
    turned = weights[1][..., None] * vector
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        matrix[..., j, i] += turned[..., k]
        matrix[..., i, j] -= turned[..., k]
    return matrix
