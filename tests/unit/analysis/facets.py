"""The polynomial of a facet, written out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def facet_value(coefficients: Floats, r: Floats, c: Floats) -> tuple[Floats, Floats, Floats]:
    """Return value and derivatives by r and c of each facet at offsets (r, c) from its centre."""
    one, zero = np.ones_like(r), np.zeros_like(r)
    basis_r, slope_r = np.stack([one, r, r**2 - 2 / 3], 1), np.stack([zero, one, 2 * r], 1)
    basis_c, slope_c = np.stack([one, c, c**2 - 2 / 3], 1), np.stack([zero, one, 2 * c], 1)
    value = np.einsum("pi,pij,pj->p", basis_r, coefficients, basis_c)
    by_r = np.einsum("pi,pij,pj->p", slope_r, coefficients, basis_c)
    by_c = np.einsum("pi,pij,pj->p", basis_r, coefficients, slope_c)
    return value, by_r, by_c
