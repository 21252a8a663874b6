"""Measured poses of a campaign, all shots in arrays."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Body
from analysis.effects.flight.wind import NOMINAL_DRAG
from analysis.model.data.parts import Kept, cut, in_memory
from analysis.model.data.plate import LEVEL, Plate
from analysis.model.fitting.systematics import Systematic, of_air, of_images, of_lengths, of_plate
from analysis.schema.verdict import TornTrack
from analysis.setup import DRAG_SIGMA, NO_SLOW_ERRORS, CameraSetup, SlowErrors

Frame = tuple[int, int]
"""Number of a shot, and the index of one of its frames."""
LEAST_COORDINATES = 2
ARRAYS = ("shots", "times_s", "position", "position_sigma", "rotation", "rotation_sigma")

T = TypeVar("T")


class Observations(Protocol):
    """What every kind of data says of its shots, whatever was measured in them."""

    @property
    def shots(self) -> NDArray[np.intp]:
        """Numbers of the shots, shape (S,)."""

    @property
    def bodies(self) -> tuple[Body, Body]:
        """Spheres a and b."""

    @property
    def gravity(self) -> float:
        """m/s^2 along +X."""

    @property
    def covariates(self) -> Mapping[str, Floats]:
        """What else is known of each shot, each of shape (S,)."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseData:
    """Poses of both spheres in every frame of every shot, padded to the longest shot.

    S shots, F frames, spheres in the order a, b; rig axes, SI units.

    Attributes
    ----------
    shots
        Numbers of the shots, shape (S,).
    times_s
        Time of each frame from the shot's first, or from the lowest of a bounce, shape (S, F).
    position, position_sigma
        Centres and standard errors, m, shape (S, F, 2, 3). An infinite sigma: not measured.
    rotation
        Orientations, body to rig axes, shape (S, F, 2, 3, 3).
    rotation_sigma
        Standard error of an orientation, the root mean square of those about the three axes, rad,
        shape (S, F, 2). Infinite: not measured.
    bodies
        Spheres a and b.
    gravity
        m/s^2 along +X.
    air_density
        kg/m^3.
    drag_coefficient, drag_sigma
        Drag coefficient of the spheres in air, 1, and its standard error; None: not stated.
    covariates
        What else is known of each shot, by name, each of shape (S,): `order` from -0.5 to 0.5 in
        the order of firing, and every numeric column of the shot list.
    unused
        Columns of the shot list that are no covariates, with the reason.
    camera
        Rates, views and origins: what a camera effect needs to know.
    estimated
        Whether some errors were not stated, so that their scale is the scatter's.
    unusable
        Numbers of shots that are not here, having no frames that show both spheres, or no bounce.
    excluded
        Numbers of shots that are not here because a person left them out.
    torn
        Shot number, sphere, first and last frame of what was cut of tracks that leave free flight.
    slow
        Errors that last, of a typical shot.
    own_slow
        The same of single shots, by their numbers.
    jitter_s
        Standard deviation of each frame's time, common to both spheres, s.
    length_sigma
        Relative standard error of all lengths together, the diameters included, where it is stated.
    plate
        How the plate lies, where b is one.
    turn_shape
        As in `ShotPoses`, shape (S, F, 2, 3, 3). Impacts are measured by all of it, a model's
        residuals by `turn_sigma`. None: the same about each axis.
    """

    shots: NDArray[np.intp]
    times_s: Floats
    position: Floats
    position_sigma: Floats
    rotation: Floats
    rotation_sigma: Floats
    bodies: tuple[Body, Body]
    gravity: float
    air_density: float
    covariates: Mapping[str, Floats]
    camera: CameraSetup
    estimated: bool = False
    unusable: tuple[int, ...] = ()
    excluded: tuple[int, ...] = ()
    torn: tuple[TornTrack, ...] = ()
    slow: SlowErrors = NO_SLOW_ERRORS
    jitter_s: float = 0.0
    own_slow: Mapping[int, SlowErrors] = field(default_factory=dict)
    unused: Mapping[str, str] = field(default_factory=dict)
    drag_coefficient: float | None = None
    drag_sigma: float = DRAG_SIGMA
    length_sigma: float = 0.0
    plate: Plate = LEVEL
    turn_shape: Floats | None = None

    def without(self, frames: NDArray[np.bool_]) -> PoseData:
        """Return the data with some frames taken out, mask of shape (S, F)."""
        position_sigma, rotation_sigma = self.position_sigma.copy(), self.rotation_sigma.copy()
        position_sigma[frames] = np.inf
        rotation_sigma[frames] = np.inf
        return self.with_sigmas(position_sigma, rotation_sigma)

    def without_frames(self, frames: Iterable[Frame]) -> PoseData:
        """Return the data with some frames taken out, those of other shots passed over."""
        rows = {int(number): s for s, number in enumerate(self.shots)}
        mask = np.zeros(self.times_s.shape, dtype=np.bool_)
        for number, frame in frames:
            if number in rows:
                mask[rows[number], frame] = True
        return self.without(mask)

    def with_sigmas(self, position_sigma: Floats, rotation_sigma: Floats) -> PoseData:
        """Return the data with other standard errors."""
        return replace(self, position_sigma=position_sigma, rotation_sigma=rotation_sigma)

    def of_shots(self, chosen: NDArray[np.bool_]) -> PoseData:
        """Return the data of some shots, mask of shape (S,)."""
        return self._chosen(chosen)

    def _chosen(self, chosen: NDArray[np.bool_] | slice) -> PoseData:
        parts = {name: getattr(self, name)[chosen] for name in ARRAYS}
        covariates = {name: values[chosen] for name, values in self.covariates.items()}
        shape = None if self.turn_shape is None else self.turn_shape[chosen]
        return replace(self, **parts, covariates=covariates, turn_shape=shape)

    def held_down(self, weight: Floats) -> PoseData:
        """Return the data with the sigmas of each shot divided by a weight, shape (S,)."""
        return self.with_sigmas(
            self.position_sigma / weight[:, None, None, None],
            self.rotation_sigma / weight[:, None, None],
        )

    def with_noise(self, position: float, rotation: float) -> PoseData:
        """Return the data with sigmas of positions and of orientations multiplied."""
        return self.with_sigmas(position * self.position_sigma, rotation * self.rotation_sigma)

    @property
    def turns(self) -> Floats:
        """`turn_shape`, where none is stated as well, shape (S, F, 2, 3, 3)."""
        if self.turn_shape is None:
            return np.broadcast_to(np.eye(3), self.rotation.shape)
        return self.turn_shape

    @property
    def turn_sigma(self) -> Floats:
        """Standard errors of orientations about X, Y and Z, rad, shape (S, F, 2, 3).

        Two views that share the axis Y see a turn about it worse than about X and Z.
        """
        if self.turn_shape is None:
            return np.repeat(self.rotation_sigma[..., None], 3, axis=-1)
        about = np.sqrt(np.diagonal(self.turn_shape, axis1=-2, axis2=-1))
        return self.rotation_sigma[..., None] * about

    def parts(self) -> Iterator[PoseData]:
        """Yield the data so many shots at a time."""
        return cut(self)

    def keep(self, kind: type[T]) -> Kept[T]:
        """Return where to keep what has a number for each shot: in memory."""
        return in_memory(kind)

    @property
    def count(self) -> int:
        """Number of shots."""
        return len(self.shots)

    @property
    def on_plate(self) -> bool:
        """Whether b is a plate: then every shot is one bounce, numbered as `by_bounce` does."""
        return self.bodies[1].is_plate

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Frames that show every body that moves, shape (S, F).

        In every coordinate that is measured anywhere in the shot: without a top view two are
        enough.
        """
        measured = np.isfinite(self.position_sigma[:, :, : 1 if self.on_plate else 2])
        anywhere = measured.any(axis=1, keepdims=True)
        enough = (anywhere.sum(axis=3) >= LEAST_COORDINATES).all(axis=2)
        return np.asarray((measured | ~anywhere).all(axis=(2, 3)) & enough)

    def part(self, some: slice) -> PoseData:
        """Return the data of successive shots, without copying."""
        return self._chosen(some)

    def padded(self, frames: int) -> PoseData:
        """Return the data with empty frames at the end, as many frames a shot as wanted."""
        more = frames - self.times_s.shape[1]
        if more <= 0:
            return self

        def longer(numbers: Floats, filling: Floats | float) -> Floats:
            shape = (len(numbers), more, *numbers.shape[2:])
            return np.concatenate([numbers, np.broadcast_to(filling, shape)], axis=1)

        return replace(
            self,
            times_s=longer(self.times_s, self.times_s[:, -1:]),
            position=longer(self.position, 0.0),
            position_sigma=longer(self.position_sigma, np.inf),
            rotation=longer(self.rotation, np.eye(3)),
            rotation_sigma=longer(self.rotation_sigma, np.inf),
            turn_shape=None if self.turn_shape is None else longer(self.turn_shape, np.eye(3)),
        )

    @classmethod
    def joined(cls, parts: Sequence[PoseData]) -> PoseData:
        """Return the data of shots of as many frames that follow each other in parts.

        All else is as in the first; of the covariates only those of all parts remain.
        """
        if len(parts) == 1:
            return parts[0]
        arrays: dict[str, Any] = {n: np.concatenate([getattr(p, n) for p in parts]) for n in ARRAYS}
        if any(p.turn_shape is not None for p in parts):
            arrays["turn_shape"] = np.concatenate([p.turns for p in parts])
        common = set[str].intersection(*(set(p.covariates) for p in parts))
        covariates = {
            name: np.concatenate([p.covariates[name] for p in parts])
            for name in parts[0].covariates
            if name in common
        }
        own_slow = {number: slow for p in parts for number, slow in p.own_slow.items()}
        torn = tuple(dict.fromkeys(track for p in parts for track in p.torn))
        return replace(parts[0], **arrays, covariates=covariates, own_slow=own_slow, torn=torn)

    @property
    def drag_of_flights(self) -> float | None:
        """Drag coefficient that is taken out of flights; None: of what is not stated nothing is.

        Flights of a ball are long: without air no law of contact would be seen.
        """
        unstated = self.drag_coefficient is None and self.on_plate
        return NOMINAL_DRAG if unstated else self.drag_coefficient

    @property
    def systematics(self) -> tuple[Systematic, ...]:
        """Return what all shots share and is known beforehand with an error."""
        # Of a plate no outline is seen that could be off.
        seen = SlowErrors(scale=self.slow.scale) if self.on_plate else self.slow
        return (
            *of_images(seen),
            *of_air(self.drag_of_flights, self.drag_sigma),
            *of_lengths(self.gravity, self.length_sigma),
            *(of_plate(self.plate.sigma_rad) if self.on_plate else ()),
        )

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Return which of the 12 numbers of each frame are measured, shape (S, F, 2, 6)."""
        turns = np.repeat(np.isfinite(self.rotation_sigma)[..., None], 3, axis=-1)
        return np.concatenate([np.isfinite(self.position_sigma), turns], axis=-1)
