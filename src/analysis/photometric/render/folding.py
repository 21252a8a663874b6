"""Normal equations of one view put among those of all, and unknowns taken out of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled
from analysis.photometric.render.pose import inverse_of
from analysis.photometric.render.sight import Equations

Floats = NDArray[np.float64]
Places = NDArray[np.int64]


@compiled
def fold(
    own: Equations, places: tuple[Places, Places], turn: tuple[Floats, Places], whole: Equations
) -> None:
    """Add C^T N C and C^T r to the whole, N and r being the own equations of one view.

    C puts most unknowns where they stand in the whole, and turns a few into others.

    Parameters
    ----------
    own
        The lower triangle alone.
    places
        Where each unknown stands in the whole, -1 where it does not, shape (own,); the unknowns
        that are turned, shape (turned,).
    turn
        Their derivatives to unknowns of the whole, shape (turned, others), and where those stand.
    whole
        Both triangles.
    """
    (at, bent), (change, others), size = places, turn, own.right.size
    half = np.zeros((size, others.size))
    for p in range(size):
        for q in range(bent.size):
            product = own.normal[max(p, bent[q]), min(p, bent[q])]
            for c in range(others.size):
                half[p, c] += product * change[q, c]
    for p in range(size):
        if at[p] < 0:
            continue
        whole.right[at[p]] += own.right[p]
        for q in range(p + 1):
            if at[q] >= 0:
                whole.normal[at[p], at[q]] += own.normal[p, q]
                if p != q:
                    whole.normal[at[q], at[p]] += own.normal[p, q]
        for c in range(others.size):
            whole.normal[at[p], others[c]] += half[p, c]
            whole.normal[others[c], at[p]] += half[p, c]
    for q in range(bent.size):
        for c in range(others.size):
            whole.right[others[c]] += change[q, c] * own.right[bent[q]]
            for d in range(others.size):
                whole.normal[others[c], others[d]] += change[q, c] * half[bent[q], d]


@compiled
def eliminate(whole: Equations, first: int, left: Equations) -> None:
    """Add what the whole says of all but its first unknowns, these being free (Schur)."""
    inverse, others = inverse_of(whole.normal[:first, :first]), whole.right.size - first
    gain, row = np.zeros((first, others)), np.zeros(others)
    for a in range(first):
        for k in range(first):
            for c in range(others):
                gain[a, c] += inverse[a, k] * whole.normal[k, first + c]
    for a in range(others):
        for c in range(others):
            row[c] = whole.normal[first + a, first + c]
        for k in range(first):
            for c in range(others):
                row[c] -= whole.normal[k, first + a] * gain[k, c]
            left.right[a] -= gain[k, a] * whole.right[k]
        left.right[a] += whole.right[first + a]
        for c in range(others):
            left.normal[a, c] += row[c]
