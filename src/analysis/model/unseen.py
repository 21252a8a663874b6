"""Spins that nobody measured.

Without orientations of a sphere nothing is known of its spin, so nothing of the friction of its
contact. Such a shot takes any impulse across the normal: its spin is held at zero, and in the
place of the spin among its 24 numbers stands a kick, the change of the relative velocity across the
normal. What it says of restitution, momentum, flight and camera is then free of friction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.model.poses import PoseData
from analysis.model.state import SIZE
from analysis.model.tables import ContactTable, Data

LEAST_ORIENTATIONS = 2
_NUMBERS_LESS, _KICK = 6, 2
"""Of a sphere without orientations, spin and orientation are not fitted; a kick has two numbers."""


def spins_unknown(data: PoseData) -> NDArray[np.bool_]:
    """Return which spheres have too few orientations for a spin, shape (S, 2)."""
    return np.asarray(np.isfinite(data.rotation_sigma).sum(axis=1) < LEAST_ORIENTATIONS)


def fitted_numbers(data: Data) -> NDArray[np.intp]:
    """Return how many of each shot's own numbers its data determine, shape (S,)."""
    if isinstance(data, ContactTable):
        return data.own_numbers
    unknown = spins_unknown(data)
    return np.asarray(SIZE - _NUMBERS_LESS * unknown.sum(axis=1) + _KICK * unknown.any(axis=1))
