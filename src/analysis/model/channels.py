"""What may be disturbed: columns that an unnamed cause would add to the poses.

In the contact frame of each shot: n along the normal, t along the incident surface velocity, b
across both.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from analysis.collision.operator import surface_velocity
from analysis.model.fit import Fit
from analysis.model.linear import left_jacobian
from analysis.model.poses import PoseData
from analysis.model.prediction import predict

Floats = NDArray[np.float64]

AXES = ("n", "t", "b")
SMOOTH = 5


def contact_columns(data: PoseData, fit: Fit) -> dict[str, Floats]:
    """Return a jump at contact of each velocity and spin, relative and common, each (S, N, 1)."""
    tau = np.maximum(data.times_s - fit.states.time_s[:, None], 0.0)[..., None]
    frame = _contact_frame(data, fit)
    columns: dict[str, Floats] = {}
    for kind, turning in (("velocity", False), ("spin", True)):
        for word, (first, second) in (("relative", (-0.5, 0.5)), ("common", (1.0, 1.0))):
            for name, axis in zip(AXES, frame, strict=True):
                moved = np.zeros((*data.times_s.shape, 2, 6))
                for i, share in enumerate((first, second)):
                    moved[:, :, i, 3:] = share * tau * axis[:, None] if turning else 0.0
                    moved[:, :, i, :3] = 0.0 if turning else share * tau * axis[:, None]
                if turning:
                    moved[..., 3:] = _as_turn(data, fit, moved[..., 3:], tau)
                columns[f"{word} {kind} {name}"] = whitened(data, moved)[..., None]
    return columns


def flight_columns(data: PoseData, fit: Fit) -> list[tuple[str, str, Floats]]:
    """Return smooth displacements and turns against the time from contact, each (S, N, 5)."""
    tau = data.times_s - fit.states.time_s[:, None]
    used = data.measured.any(axis=(2, 3))
    reach = float(np.quantile(np.abs(tau[used]), 0.99))
    smooth = chebyshev.chebvander(np.clip(tau / max(reach, 1e-9), -1, 1), SMOOTH - 1)
    frame = _contact_frame(data, fit)
    found = []
    for kind, part in (("position", slice(0, 3)), ("orientation", slice(3, 6))):
        for word, shares in (("relative", (-0.5, 0.5)), ("common", (1.0, 1.0))):
            for name, axis in zip(AXES, frame, strict=True):
                moved = np.zeros((*data.times_s.shape, 2, 6, SMOOTH))
                for i, share in enumerate(shares):
                    moved[:, :, i, part] = share * axis[:, None, :, None] * smooth[:, :, None, :]
                columns = [whitened(data, moved[..., k]) for k in range(SMOOTH)]
                found.append((f"{word} {kind} {name}", "time", np.stack(columns, axis=-1)))
    return found


def camera_columns(data: PoseData, fit: Fit) -> list[tuple[str, str, Floats]]:
    """Return smooth displacements of X, Y, Z against the position in the field, each (S, N, 5)."""
    position = predict(data, fit.states, fit.theory).position
    used = np.isfinite(data.position_sigma).all(axis=-1)
    found = []
    for along, covariate in enumerate("XYZ"):
        low, high = np.quantile(position[used][:, along], [0.01, 0.99])
        scaled = np.clip(2 * (position[..., along] - low) / max(high - low, 1e-9) - 1, -1, 1)
        smooth = chebyshev.chebvander(scaled, SMOOTH - 1)
        for axis, name in enumerate("XYZ"):
            columns = []
            for k in range(SMOOTH):
                moved = np.zeros((*data.times_s.shape, 2, 6))
                moved[..., axis] = smooth[..., k]
                columns.append(whitened(data, moved))
            found.append((f"image {name}", f"field {covariate}", np.stack(columns, axis=-1)))
    return found


def whitened(data: PoseData, moved: Floats) -> Floats:
    """Divide changes of the 12 numbers (S, F, 2, 6) by their sigmas, shape (S, N)."""
    turn_sigma = np.repeat(data.rotation_sigma[..., None], 3, axis=-1)
    sigma = np.concatenate([data.position_sigma, turn_sigma], axis=-1)
    return np.where(np.isfinite(sigma), moved / sigma, 0.0).reshape(len(moved), -1)


def _contact_frame(data: PoseData, fit: Fit) -> tuple[Floats, Floats, Floats]:
    """Return n, t, b of each shot, each of shape (S, 3)."""
    states = fit.states
    surface = surface_velocity(states.before, states.normal, data.bodies)
    length = np.linalg.norm(surface, axis=1, keepdims=True)
    along = np.where(length > 1e-9, surface / np.maximum(length, 1e-9), states.tangents()[0])
    return states.normal, along, np.cross(states.normal, along)


def _as_turn(data: PoseData, fit: Fit, change: Floats, tau: Floats) -> Floats:
    """Turn a change of spin times time (S, F, 2, 3) into a change of orientation."""
    before = fit.states.before
    spins = np.stack([before.spin_a, before.spin_b], axis=1)[:, None]
    response = left_jacobian(spins * tau[..., None, :])
    return np.asarray((response @ change[..., None])[..., 0])
