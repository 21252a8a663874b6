"""The poses of one shot as poses.csv carries them: all that its impact is measured from."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.motion.pattern import Orientations
from analysis.motion.poses import Centres

Frames = NDArray[np.intp]

NOT_MEASURED_M = 1e-6
"""Standard error of a coordinate that no view shows: constant, 0, as without a top view."""
LEAST_COORDINATES = 2


@dataclass(frozen=True, slots=True, eq=False)
class ShotPoses:
    """Centres and orientations of spheres a and b, frame by frame; rig axes.

    Attributes
    ----------
    frames
        Numbers of the frames, shape (F,).
    times_s
        Their times from the shot's first, s, shape (F,).
    position, position_sigma
        m, shape (F, 2, 3). An infinite sigma: not measured.
    rotation
        Body to rig axes, shape (F, 2, 3, 3).
    rotation_sigma
        Standard error about each axis, rad, shape (F, 2). Infinite: not measured.
    turn_shape
        Covariance of small turns in rig axes over the square of that error, of trace 3, shape
        (F, 2, 3, 3): markers near the middle of a view tell a turn about its axis of sight less.
    """

    frames: Frames
    times_s: Floats
    position: Floats
    position_sigma: Floats
    rotation: Floats
    rotation_sigma: Floats
    turn_shape: Floats

    @classmethod
    def of_tracks(
        cls,
        centres: tuple[Centres, Centres],
        orientations: tuple[Orientations, Orientations],
        times_s: Floats,
    ) -> ShotPoses:
        """Return the poses of tracked spheres, `times_s` of all frames of the film."""
        frames = np.union1d(centres[0].frames, centres[1].frames)
        shape = (len(frames), 2)
        position, position_sigma = np.zeros((*shape, 3)), np.full((*shape, 3), np.inf)
        rotation, rotation_sigma = np.tile(np.eye(3), (*shape, 1, 1)), np.full(shape, np.inf)
        turn_shape = rotation.copy()
        for i, (placed, turned) in enumerate(zip(centres, orientations, strict=True)):
            rows = np.searchsorted(frames, placed.frames)
            position[rows, i] = np.nan_to_num(placed.position)
            position_sigma[rows, i] = placed.sigma
            shown = np.isin(turned.frames, placed.frames)
            rows = np.searchsorted(frames, turned.frames[shown])
            rotation[rows, i] = turned.rotation[shown]
            own = turned.covariance[shown]
            rotation_sigma[rows, i] = isotropic(own)
            turn_shape[rows, i] = shape_of(own)
        times_s = times_s[frames]
        return cls(frames, times_s, position, position_sigma, rotation, rotation_sigma, turn_shape)

    @property
    def turned(self) -> NDArray[np.bool_]:
        """Which orientations are measured, shape (F, 2)."""
        return np.isfinite(self.rotation_sigma)

    @property
    def placed(self) -> NDArray[np.bool_]:
        """Which spheres have any coordinate measured, shape (F, 2)."""
        return np.asarray(np.isfinite(self.position_sigma).any(axis=2))

    def track(self, sphere: int, rows: Frames) -> Centres:
        """Return the places of a sphere in some of the rows."""
        position, sigma = self.position[rows, sphere], self.position_sigma[rows, sphere]
        return Centres(self.frames[rows], position, sigma)

    def clock(self) -> Floats:
        """Return the time of each frame by its number, s; 0 for those without poses."""
        times_s = np.zeros(self.frames[-1] + 1 if self.frames.size else 0)
        times_s[self.frames] = self.times_s
        return times_s

    def both_shown(self) -> NDArray[np.bool_]:
        """Return which frames show both spheres, in two coordinates at least, shape (F,)."""
        seen = np.isfinite(self.position_sigma).sum(axis=2) >= LEAST_COORDINATES
        return np.asarray(seen.all(axis=1))

    def without(self, left_out: NDArray[np.bool_]) -> ShotPoses:
        """Return the poses without those of some spheres in some frames, mask of shape (F, 2)."""
        return replace(
            self,
            position_sigma=np.where(left_out[..., None], np.inf, self.position_sigma),
            rotation_sigma=np.where(left_out, np.inf, self.rotation_sigma),
        )

    def without_turns(self, left_out: NDArray[np.bool_]) -> ShotPoses:
        """Return the poses without some orientations, mask of shape (F, 2)."""
        return replace(self, rotation_sigma=np.where(left_out, np.inf, self.rotation_sigma))

    def flat(self) -> ShotPoses:
        """Return the poses with a coordinate that is measured nowhere as constant, 0."""
        nowhere = np.isinf(self.position_sigma).all(axis=(0, 1))
        return replace(
            self,
            position=np.where(nowhere, 0.0, self.position),
            position_sigma=np.where(nowhere, NOT_MEASURED_M, self.position_sigma),
        )


def isotropic(covariance: Floats) -> Floats:
    """Return the standard error about each axis, rad, of covariances (n, 3, 3), shape (n,)."""
    return np.asarray(np.sqrt(np.trace(covariance, axis1=1, axis2=2) / 3))


def shape_of(covariance: Floats) -> Floats:
    """Return covariances (..., 3, 3) over their mean variance, as `ShotPoses.turn_shape`."""
    mean = np.trace(covariance, axis1=-2, axis2=-1) / 3
    return np.asarray(covariance / mean[..., None, None])
