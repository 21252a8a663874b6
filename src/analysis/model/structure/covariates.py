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


LABELS = {
    "ln v_n": "ln(v_n / (m/s)), approach speed before contact",
    "ln v_s/v_n": "ln(v_s / v_n), surface speed over approach speed",
    "spin along v_t x n": "spin along v_t × n, rad/s",
    "spin about n": "relative spin about n, rad/s",
    "contact X": "contact at X, m",
    "contact Y": "contact at Y, m",
    "contact Z": "contact at Z, m",
    "order": "order of firing, first to last",
    "time": "time from contact, s",
    "field X": "position X in the field, m",
    "field Y": "position Y in the field, m",
    "field Z": "position Z in the field, m",
}
_UNITS = {"kpa": "kPa", "mm": "mm", "us": "µs", "c": "°C", "s": "s", "m": "m", "deg": "°"}


def covariate_label(name: str) -> str:
    """Return a covariate with its unit, for the axis of a picture.

    The unit of a column of the shot list is the last word of its name, as in `offset_mm`.
    """
    if name in LABELS:
        return LABELS[name]
    words, _, unit = name.rpartition("_")
    if words and unit in _UNITS:
        return f"{words.replace('_', ' ')}, {_UNITS[unit]}"
    return name.replace("_", " ")


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
