"""Spins that nobody measured.

Without orientations of a sphere, or where no table gives it, nothing is known of its spin, so
nothing of the friction of its contact. Such a shot takes any impulse across the normal: its spin is
held at zero, and in the place of the spin among its 24 numbers stands a kick, the change of the
relative velocity across the normal. What it says of restitution, momentum, flight and camera is
then free of friction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.tables import ContactTable, Data
from analysis.model.predict.state import KICK_NUMBERS, SIZE

LEAST_ORIENTATIONS = 2
_NUMBERS_LESS = 6
"""Of a sphere without orientations, spin and orientation are not fitted."""


def spins_unknown(data: Data) -> NDArray[np.bool_]:
    """Return which spheres have too few orientations for a spin, or none tabulated, (S, 2)."""
    if isinstance(data, ContactTable):
        return data.spins_unknown
    return np.asarray(np.isfinite(data.rotation_sigma).sum(axis=1) < LEAST_ORIENTATIONS)


def fitted_numbers(data: Data) -> NDArray[np.intp]:
    """Return how many of each shot's own numbers its data determine, shape (S,)."""
    if isinstance(data, ContactTable):
        return data.own_numbers
    unknown = spins_unknown(data)
    return np.asarray(
        SIZE - _NUMBERS_LESS * unknown.sum(axis=1) + KICK_NUMBERS * unknown.any(axis=1)
    )
