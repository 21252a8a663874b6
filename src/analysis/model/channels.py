"""What may be disturbed: columns that an unnamed cause would add to the poses.

In the contact frame of each shot: n along the normal, t along the incident surface velocity, b
across both.
"""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True, slots=True, eq=False)
class FrameChannel:
    """A displacement or turn that hangs smoothly on something known of each frame.

    Attributes
    ----------
    name, covariate
        What is disturbed, and against what.
    unit
        Of the disturbance: m or rad.
    place
        The covariate of each frame, shape (S, F, 1) if both spheres move as one, else (S, F, 2).
    smooth
        Five smooth functions of it, shape (S, F, 1 or 2, 5).
    direction
        What a disturbance of one unit adds to the 12 numbers of a frame, shape (S, F, 2, 6).
    """

    name: str
    covariate: str
    unit: str
    place: Floats
    smooth: Floats
    direction: Floats

    def whitened(self, data: PoseData) -> Floats:
        """Return the direction, each number divided by its sigma, shape (S, F, 2, 6)."""
        return whitened(data, self.direction).reshape(self.direction.shape)

    def columns(self, data: PoseData) -> Floats:
        """Return the whitened columns, one for each smooth function, shape (S, N, 5)."""
        parts = [
            whitened(data, self.direction * self.smooth[..., k, None])
            for k in range(self.smooth.shape[-1])
        ]
        return np.stack(parts, axis=-1)


def flight_channels(data: PoseData, fit: Fit) -> list[FrameChannel]:
    """Return displacements and turns against the time from contact."""
    tau = data.times_s - fit.states.time_s[:, None]
    used = data.measured.any(axis=(2, 3))
    reach = float(np.quantile(np.abs(tau[used]), 0.99))
    scaled = np.clip(tau / max(reach, 1e-9), -1, 1)
    smooth = np.asarray(chebyshev.chebvander(scaled, SMOOTH - 1), dtype=np.float64)
    frame = _contact_frame(data, fit)
    found = []
    for kind, unit, part in (("position", "m", slice(0, 3)), ("orientation", "rad", slice(3, 6))):
        for word, shares in (("relative", (-0.5, 0.5)), ("common", (1.0, 1.0))):
            for name, axis in zip(AXES, frame, strict=True):
                direction = np.zeros((*data.times_s.shape, 2, 6))
                for i, share in enumerate(shares):
                    direction[:, :, i, part] = share * axis[:, None]
                found.append(
                    FrameChannel(
                        name=f"{word} {kind} {name}",
                        covariate="time",
                        unit=unit,
                        place=tau[..., None],
                        smooth=smooth[:, :, None],
                        direction=direction,
                    )
                )
    return found


def camera_channels(data: PoseData, fit: Fit) -> list[FrameChannel]:
    """Return displacements of X, Y, Z against the position in the field."""
    position = predict(data, fit.states, fit.theory).position
    used = np.isfinite(data.position_sigma).all(axis=-1)
    found = []
    for along, covariate in enumerate("XYZ"):
        place = position[..., along]
        low, high = np.quantile(place[used], [0.01, 0.99])
        scaled = np.clip(2 * (place - low) / max(high - low, 1e-9) - 1, -1, 1)
        smooth = np.asarray(chebyshev.chebvander(scaled, SMOOTH - 1), dtype=np.float64)
        for axis, name in enumerate("XYZ"):
            direction = np.zeros((*data.times_s.shape, 2, 6))
            direction[..., axis] = 1.0
            found.append(
                FrameChannel(f"image {name}", f"field {covariate}", "m", place, smooth, direction)
            )
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
