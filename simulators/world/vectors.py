"""Vectors of three numbers, for loops over thousands of steps of a contact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Triple = tuple[float, float, float]
"""Plain numbers: NumPy's arrays of three take some ten times as long."""


def triple(a: Floats) -> Triple:
    """Return the numbers of an array of three."""
    x, y, z = a.tolist()
    return x, y, z


def dot(a: Triple, b: Triple) -> float:
    """Return the product a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def times(factor: float, a: Triple) -> Triple:
    """Return a vector that is longer by a factor."""
    return factor * a[0], factor * a[1], factor * a[2]


def added(a: Triple, factor: float, b: Triple) -> Triple:
    """Return a + factor b."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


def crossed(a: Triple, b: Triple) -> Triple:
    """Return the product a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
