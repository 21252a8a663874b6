"""What may be disturbed: columns that an unnamed cause would add to the poses.

In the contact frame of each shot: n along the normal, t along the incident surface velocity, b
across both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from analysis.arrays import Floats
from analysis.collision.operator import surface_velocity
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.predict.comparison import weights
from analysis.model.predict.contact import AFTER, contact_outcome
from analysis.model.predict.linear import left_jacobian
from analysis.model.predict.prediction import predict
from analysis.model.predict.sides import NUMBERS, place_of_rate
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory
from analysis.model.structure.layout import AXES
from analysis.model.structure.reach import TIME, Reach

SMOOTH = 5
PAIRS = (("relative", (-0.5, 0.5)), ("common", (1.0, 1.0)))
"""Shares of a and b."""
ON_PLATE = (("relative", (-1.0, 0.0)),)
SCALARS = ("relative velocity n", "relative velocity t")


def pairs_of(data: Data) -> tuple[tuple[str, tuple[float, float]], ...]:
    """Return the motions of both bodies that there are: beside a plate, relative ones alone."""
    return ON_PLATE if data.bodies[1].is_plate else PAIRS


def contact_columns(data: Data, states: ShotStates, theory: Theory) -> dict[str, Floats]:
    """Return a jump at contact of each velocity and spin, relative and common, each (S, N, 1).

    Of scalars the relative velocity along n and t alone.
    """
    if isinstance(data, ContactTable):
        return _tabulated_columns(data, states)
    tau = np.maximum(data.times_s - states.time_s[:, None], 0.0)[..., None]
    weight = weights(data) * tau[:, :, None]
    turn = weight[..., 3:, None] * _turn_by_spin(data, states, theory, tau)
    shots, frames = data.times_s.shape
    columns: dict[str, Floats] = {}
    for kind, turning in (("velocity", False), ("spin", True)):
        for word, shares in pairs_of(data):
            for name, axis in zip(AXES, contact_frame(data, states), strict=True):
                moved = np.zeros((shots, frames, 2, 6))
                for i, share in enumerate(shares):
                    own = share * axis[:, None]
                    if turning:
                        moved[:, :, i, 3:] = (turn[:, :, i] @ own[..., None])[..., 0]
                    else:
                        moved[:, :, i, :3] = weight[:, :, i, :3] * own
                columns[f"{word} {kind} {name}"] = moved.reshape(shots, -1, 1)
    return columns


def _tabulated_columns(table: ContactTable, states: ShotStates) -> dict[str, Floats]:
    response, frame = table.weights[..., None] * table.functional, contact_frame(table, states)
    columns: dict[str, Floats] = {}
    for kind, turning in (("velocity", False), ("spin", True)):
        for word, shares in pairs_of(table):
            for name, axis in zip(AXES, frame, strict=True):
                moved = np.zeros((len(table.shots), NUMBERS))
                for i, share in enumerate(shares):
                    moved[:, place_of_rate(i, spin=turning, after=True)] = share * axis
                columns[f"{word} {kind} {name}"] = response @ moved[..., None]
    return {name: columns[name] for name in SCALARS} if table.scalars else columns


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
    weights
        1 / sigma of these, zero where nothing was measured, shape (S, F, 2, 6).
    """

    name: str
    covariate: str
    unit: str
    place: Floats
    smooth: Floats
    direction: Floats
    weights: Floats

    def whitened(self) -> Floats:
        """Return the direction, each number divided by its sigma, shape (S, F, 2, 6)."""
        return self.direction * self.weights

    def columns(self) -> Floats:
        """Return the whitened columns, one for each smooth function, shape (S, N, 5)."""
        columns = self.whitened()[..., None] * self.smooth[..., None, :]
        return columns.reshape(len(self.direction), -1, self.smooth.shape[-1])

    def lines(self, reach: Reach) -> Floats:
        """Return sums of products of 1, place and the smooth functions on each side, (2, 7, 7).

        Of all that was measured, after the contact and before, or along the field; places scaled.
        """
        seen = np.asarray((self.weights > 0).any(axis=3))
        if self.place.shape[2] == 1:
            seen = np.asarray(seen.any(axis=2, keepdims=True))
        later = (self.place > 0) & (self.covariate == TIME)
        scaled = reach.of(self.covariate).places(self.place)
        sums = []
        for side in (seen & later, seen & ~later):
            line = np.stack([np.ones(int(side.sum())), scaled[side]], axis=1)
            design = np.concatenate([line, self.smooth[side]], axis=1)
            sums.append(design.T @ design)
        return np.stack(sums)


def frame_channels(
    data: Data, states: ShotStates, theory: Theory, reach: Reach
) -> tuple[FrameChannel, ...]:
    """Return all of flight and camera; a table of contacts has none."""
    if isinstance(data, ContactTable):
        return ()
    return (
        *flight_channels(data, states, reach),
        *camera_channels(data, states, theory, reach),
    )


def flight_channels(data: PoseData, states: ShotStates, reach: Reach) -> list[FrameChannel]:
    """Return displacements and turns against the time from contact."""
    tau = data.times_s - states.time_s[:, None]
    scaled = reach.time.scaled(tau)
    smooth = np.asarray(chebyshev.chebvander(scaled, SMOOTH - 1), dtype=np.float64)
    frame, weight = contact_frame(data, states), weights(data)
    found = []
    for kind, unit, part in (("position", "m", slice(0, 3)), ("orientation", "rad", slice(3, 6))):
        for word, shares in pairs_of(data):
            for name, axis in zip(AXES, frame, strict=True):
                direction = np.zeros((*data.times_s.shape, 2, 6))
                for i, share in enumerate(shares):
                    direction[:, :, i, part] = share * axis[:, None]
                found.append(
                    FrameChannel(
                        name=f"{word} {kind} {name}",
                        covariate=TIME,
                        unit=unit,
                        place=tau[..., None],
                        smooth=smooth[:, :, None],
                        direction=direction,
                        weights=weight,
                    )
                )
    return found


def camera_channels(
    data: PoseData, states: ShotStates, theory: Theory, reach: Reach
) -> list[FrameChannel]:
    """Return displacements of X, Y, Z against the position in the field."""
    position, weight = predict(data, states, theory).position, weights(data)
    found = []
    for along, covariate in enumerate("XYZ"):
        place = position[..., along]
        scaled = reach.field[along].scaled(place)
        smooth = np.asarray(chebyshev.chebvander(scaled, SMOOTH - 1), dtype=np.float64)
        for axis, name in enumerate("XYZ"):
            direction = np.zeros((*data.times_s.shape, 2, 6))
            direction[..., axis] = 1.0
            found.append(
                FrameChannel(
                    name=f"image {name}",
                    covariate=f"field {covariate}",
                    unit="m",
                    place=place,
                    smooth=smooth,
                    direction=direction,
                    weights=weight,
                )
            )
    return found


def whitened(data: PoseData, moved: Floats) -> Floats:
    """Divide changes of the 12 numbers (S, F, 2, 6) by their sigmas, shape (S, N)."""
    sigma = np.concatenate([data.position_sigma, data.turn_sigma], axis=-1)
    return np.where(np.isfinite(sigma), moved / sigma, 0.0).reshape(len(moved), -1)


def contact_frame(data: Data, states: ShotStates) -> tuple[Floats, Floats, Floats]:
    """Return n, t, b of each shot, each of shape (S, 3)."""
    surface = surface_velocity(states.before, states.normal, data.bodies)
    length = np.linalg.norm(surface, axis=1, keepdims=True)
    along = np.where(length > 1e-9, surface / np.maximum(length, 1e-9), states.tangents()[0])
    return states.normal, along, np.cross(states.normal, along)


def _turn_by_spin(data: PoseData, states: ShotStates, theory: Theory, tau: Floats) -> Floats:
    """Return the turn by a change of spin after contact, over the time, shape (S, F, 2, 3, 3)."""
    after = contact_outcome(data, states, theory)[:, AFTER]
    spins = after.reshape(-1, 1, 4, 3)[:, :, 2:]
    return left_jacobian(spins * tau[..., None, :])
