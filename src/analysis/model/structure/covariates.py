"""What a residual may depend on, one number a shot, taken from the prediction.

Never from the observed pose: its noise would stand in the covariate and in the residual at once.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import surface_velocity
from analysis.model.data.tables import ContactTable, Data
from analysis.model.predict.state import ShotStates

LEAST_SPEED = 1e-3


def shot_covariates(data: Data, states: ShotStates) -> dict[str, Floats]:
    """Return every covariate of the shots, each of shape (S,).

    ln v_n, ln(v_s / v_n), spins along v_t x n and along n, where the contact was (rig axes, m), and
    what the shot list holds. A table does not say where the contact was, and scalars nothing of the
    spins.
    """
    before = states.before
    relative = before.velocity_b - before.velocity_a
    approach = np.maximum(-(relative * states.normal).sum(axis=1), LEAST_SPEED)
    surface = surface_velocity(before, states.normal, data.bodies)
    sliding = np.maximum(np.linalg.norm(surface, axis=1), LEAST_SPEED)
    across = relative + approach[:, None] * states.normal
    length = np.maximum(np.linalg.norm(across, axis=1, keepdims=True), LEAST_SPEED)
    roll_axis = np.cross(across / length, states.normal)
    speeds = {"ln v_n": np.log(approach), "ln v_s/v_n": np.log(sliding / approach)}
    spins = {
        "spin along v_t x n": ((before.spin_a + before.spin_b) * roll_axis).sum(axis=1),
        "spin about n": ((before.spin_b - before.spin_a) * states.normal).sum(axis=1),
    }
    if isinstance(data, ContactTable):
        return {**speeds, **({} if data.scalars else spins), **data.covariates}
    places = {f"contact {axis}": states.point[:, k] for k, axis in enumerate("XYZ")}
    return {**speeds, **spins, **places, **data.covariates}
