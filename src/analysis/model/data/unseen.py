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

from analysis.model.data.poses import PoseData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.predict.state import KICK_NUMBERS, MOTION, POINT, SIZE, TIME, TURN_A

LEAST_ORIENTATIONS = 2
_NUMBERS_LESS = 6
"""Of a sphere without orientations, spin and orientation are not fitted."""


def spins_unknown(data: Data) -> NDArray[np.bool_]:
    """Return which spheres have too few orientations for a spin, or none tabulated, (S, 2)."""
    if isinstance(data, ContactTable):
        return data.spins_unknown
    moves = np.array([not body.is_plate for body in data.bodies])
    return np.asarray((np.isfinite(data.rotation_sigma).sum(axis=1) < LEAST_ORIENTATIONS) & moves)


def numbers_of_bounces(data: PoseData) -> NDArray[np.bool_]:
    """Return which of the 24 numbers of each bounce on a plate are fitted, shape (S, 24).

    The plate rests, and its normal is that of all bounces. Nothing is fitted along an axis that no
    frame shows: a plate that leans makes of a velocity that nobody knows any restitution.
    """
    unknown = spins_unknown(data)[:, 0]
    shown = np.asarray(np.isfinite(data.position_sigma[:, :, 0]).any(axis=1))
    fitted = np.zeros((len(shown), SIZE), dtype=np.bool_)
    fitted[:, TIME] = True
    fitted[:, POINT] = fitted[:, MOTION.start : MOTION.start + 3] = shown
    spin = slice(MOTION.start + 6, MOTION.start + 9)
    fitted[:, spin] = np.where(unknown[:, None], shown, True)
    fitted[:, TURN_A] = ~unknown[:, None]
    return fitted


def fitted_numbers(data: Data) -> NDArray[np.intp]:
    """Return how many of each shot's own numbers its data determine, shape (S,)."""
    if isinstance(data, ContactTable):
        return data.nuisance_count
    unknown = spins_unknown(data)
    if data.on_plate:
        # Of a kick what lies along the normal, +X, has no effect.
        return np.asarray(numbers_of_bounces(data).sum(axis=1) - unknown[:, 0])
    return np.asarray(
        SIZE - _NUMBERS_LESS * unknown.sum(axis=1) + KICK_NUMBERS * unknown.any(axis=1)
    )
