"""The comparison of prediction and data to first order: residuals and all derivatives.

A pose depends on the state of its shot and on the law of contact through the 48 numbers of the two
flights alone, so derivatives are kept as those of the poses by the 48 (`slopes`), and of the 48 by
whatever moves them. Only what acts on frames (flight, camera, clock) has columns of frame length.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.instant import parting_time
from analysis.collision.operator import Body
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.data.unseen import numbers_of_bounces
from analysis.model.fitting.jitter import Jitter, turning_by_frame
from analysis.model.fitting.shared_noise import SharedNoise
from analysis.model.fitting.slow_errors.whitening import slow_noise
from analysis.model.loops import plain
from analysis.model.loops.blocks import information
from analysis.model.loops.misfit import misfits, slopes_of
from analysis.model.predict.contact import differentiated_contact
from analysis.model.predict.prediction import Flown, OnWay, Poses, appear, fly, rate, shown
from analysis.model.predict.sides import (
    NUMBERS,
    Flights,
    flights,
    flights_by_state,
    place_of_rate,
    rates_of,
)
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory
from analysis.motion.rotation import rotation_vector


def parting(sides: Flights, bodies: tuple[Body, Body], normal: Floats) -> tuple[Floats, Floats]:
    """Return durations, s, shape (S,), and their slopes by the 48 numbers, shape (S, 48).

    Flights are those that leave at first touch, extrapolated; the bodies part where their surfaces
    do on these. Hard spheres part at once.

    Parameters
    ----------
    normal
        From a to b at first touch, shape (S, 3): that of a plate stays.
    """
    gap = sides.place[:, 1, 1] - sides.place[:, 0, 1]
    opening = sides.velocity[:, 1, 1] - sides.velocity[:, 0, 1]
    reach = bodies[0].radius + bodies[1].radius
    if bodies[1].is_plate:
        along = (opening * normal).sum(axis=1)
        lasts = (reach - (gap * normal).sum(axis=1)) / along
        line = normal
    else:
        lasts = parting_time(gap, opening, np.full(len(gap), reach))
        # Paths that pass each other by say nothing better than the contact itself.
        lasts = np.where(np.isfinite(lasts), lasts, sides.duration)
        line = (gap + opening * lasts[:, None]) / reach
        along = (opening * line).sum(axis=1)
    slopes = np.zeros((len(gap), NUMBERS))
    for sphere, sign in ((0, 1.0), (1, -1.0)):
        rate = place_of_rate(sphere, spin=False, after=True)
        start = slice(rate.start - 3, rate.start)
        slopes[:, start] = sign * line / along[:, None]
        slopes[:, rate] = slopes[:, start] * lasts[:, None]
    return lasts, slopes


_CAMERA_STEP = 1e-6
KINDS = 4
"""Blocks of residuals: position of a, orientation of a, position of b, orientation of b."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Whitened residuals of S shots and their slopes.

    Attributes
    ----------
    residual
        (observed - predicted) / sigma, B blocks of L numbers; orientations as rotation vectors of
        R_observed R_predicted'. Zero where nothing was measured. Shape (S, B, L).
    slopes
        Derivatives of the prediction, over sigma, by the 48 / B numbers of the flights that a block
        depends on, shape (S, B, L, 48 / B).
    gram
        slopes' slopes, shape (S, B, 48 / B, 48 / B).
    by_state
        Derivatives of the 48 numbers by the 24 of the shot, shape (S, 48, 24).
    orientations
        Which residuals are of orientations, shape (B, L).
    shared
        Noise that frames or numbers share, where the data have such.
    """

    residual: Floats
    slopes: Floats
    gram: Floats
    by_state: Floats
    orientations: NDArray[np.bool_]
    shared: SharedNoise | None = None

    @property
    def chi2(self) -> Floats:
        """Chi-squared of each shot, shape (S,)."""
        return np.asarray((self.residual**2).sum(axis=(1, 2)))

    @cached_property
    def information(self) -> Floats:
        """Information on the 24 numbers of each shot, shape (S, 24, 24)."""
        return information(plain(self.by_state), plain(self.gram))

    @cached_property
    def downhill(self) -> Floats:
        """Downhill by the 24 numbers of each shot, shape (S, 24)."""
        return (np.swapaxes(self.by_state, 1, 2) @ self.pulled[..., None])[..., 0]

    @cached_property
    def pulled(self) -> Floats:
        """Slope times residual: downhill by the 48 numbers, shape (S, 48)."""
        return self.pull(self.residual[..., None])[..., 0]

    def recast(self, columns: Floats) -> Floats:
        """Bring columns by spheres and kinds (S, 4, 3 F, K) into this comparison's blocks."""
        return columns if self.shared is None else self.shared.whiten(columns)

    def pull(self, columns: Floats) -> Floats:
        """Return slopes' columns: of residual length (S, B, L, K) to (S, 48, K)."""
        pulled = np.swapaxes(self.slopes, 2, 3) @ columns
        return pulled.reshape(len(columns), NUMBERS, -1)

    def weigh(self, moved: Floats) -> Floats:
        """Return gram times changes of the 48 numbers, shape (S, 48, K)."""
        shots, blocks, size = self.gram.shape[:3]
        return (self.gram @ moved.reshape(shots, blocks, size, -1)).reshape(moved.shape)


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """A prediction with the steps on its way, for changes of one step alone.

    Attributes
    ----------
    outcome, about
        Of the contacts, and what differences of it are taken from, shape (S, 25).
    sides
        The flights that it leads to.
    frames
        What frames show of them; tabulated contacts have none.
    """

    outcome: Floats
    about: Floats
    sides: Flights
    frames: Frames | None


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """What frames show of a prediction; tabulated contacts have none."""

    way: OnWay
    poses: Poses

    @property
    def flown(self) -> Flown:
        """The flights before small forces and the camera."""
        return self.way.flown


def compare(data: Data, states: ShotStates, theory: Theory) -> tuple[Comparison, Snapshot]:
    """Predict all that was measured and compare, to first order about the states.

    What forces in flight and the clock change with the state is left out, being small.
    """
    contact = differentiated_contact(data, states, theory)
    sides = flights(data, states, contact.outcome)
    by_state = flights_by_state(data, states, sides, contact.outcome, contact.by_state)
    if isinstance(data, ContactTable):
        return _tabulated(data, sides, by_state), Snapshot(
            contact.outcome, contact.about, sides, None
        )
    if data.on_plate:
        by_state = by_state * numbers_of_bounces(data)[:, None]
    flown = fly(data, states, sides, theory)
    way = OnWay(data, flown, theory.flight)
    poses = shown(way, theory)
    residual, (slopes, gram) = misfit(data, poses), _slopes(data, flown, theory)
    turning = np.repeat((np.arange(KINDS) % 2 == 1)[:, None], slopes.shape[2], axis=1)
    shared = _shared_noise(data, states, (sides, flown), slopes)
    if shared is not None:
        residual = shared.whiten(residual[..., None])[..., 0]
        if shared.jitter is not None:
            slopes, turning = _spread(slopes), turning_by_frame(data.times_s.shape[1])
        slopes = shared.whiten(slopes)
        gram = np.swapaxes(slopes, 2, 3) @ slopes
    line = Comparison(
        residual=residual,
        slopes=slopes,
        gram=gram,
        by_state=by_state,
        orientations=turning,
        shared=shared,
    )
    frames = Frames(way, poses)
    return line, Snapshot(contact.outcome, contact.about, sides, frames)


def _shared_noise(
    data: PoseData, states: ShotStates, ways: tuple[Flights, Flown], slopes: Floats
) -> SharedNoise | None:
    sides, flown = ways
    slow = slow_noise(data, states, sides, slopes)
    jitter = Jitter(rates(data, flown), data.jitter_s) if data.jitter_s > 0 else None
    return None if slow is None and jitter is None else SharedNoise(slow, jitter)


def _tabulated(table: ContactTable, sides: Flights, by_state: Floats) -> Comparison:
    """Compare tabulated numbers, one block of them, with the flights' rates and the duration."""
    weights = table.weights
    predicted, slopes = rates_of(sides) @ table.functional.T, weights[..., None] * table.functional
    if table.lasts:
        predicted[:, -1], by_flights = parting(sides, table.bodies, table.normal)
        slopes[:, -1] = weights[:, -1:] * by_flights
    slopes = slopes[:, None]
    return Comparison(
        residual=(weights * (table.numbers - predicted))[:, None],
        slopes=slopes,
        gram=np.swapaxes(slopes, 2, 3) @ slopes,
        by_state=by_state * table.open,
        orientations=np.zeros((1, table.numbers.shape[1]), dtype=np.bool_),
    )


def misfit(data: PoseData, poses: Poses) -> Floats:
    """Return observed less predicted, over sigma, by spheres and kinds, shape (S, 4, 3 F)."""
    return misfits(
        (plain(data.position), plain(data.rotation)),
        (plain(poses.position), plain(poses.rotation)),
        _sigmas(data),
    )


def _sigmas(data: PoseData) -> tuple[Floats, Floats]:
    return plain(data.position_sigma), plain(data.turn_sigma)


def difference(poses: Poses, moved: Poses) -> Floats:
    """Return the change from one prediction to another, m and rad, shape (S, F, 2, 6)."""
    turned = rotation_vector(moved.rotation @ np.swapaxes(poses.rotation, -1, -2))
    return np.concatenate([moved.position - poses.position, turned], axis=-1)


def weights(data: PoseData) -> Floats:
    """Return 1 / sigma, zero where nothing was measured, shape (S, F, 2, 6)."""
    sigma = np.concatenate([data.position_sigma, data.turn_sigma], axis=-1)
    return np.where(np.isfinite(sigma), 1.0 / sigma, 0.0)


def rates(data: PoseData, flown: Flown) -> Floats:
    """Return the whitened change of the prediction with time, 1/s, shape (S, F, 2, 6)."""
    return np.concatenate([rate(data, flown), flown.spin], axis=-1) * weights(data)


def _spread(slopes: Floats) -> Floats:
    """Set slopes of blocks (S, 4, 3 F, 12) beside each other, (S, 4, 3 F, 48)."""
    shots, blocks, length, size = slopes.shape
    wide = np.zeros((shots, blocks, length, blocks, size))
    for block in range(blocks):
        wide[:, block, :, block] = slopes[:, block]
    return wide.reshape(shots, blocks, length, blocks * size)


def by_block(numbers: Floats) -> Floats:
    """Sort numbers (S, F, 2, 6, ...) into blocks of spheres and kinds, (S, 4, 3 F, ...)."""
    shots, frames, *_ = numbers.shape
    rest = numbers.shape[4:]
    parted = numbers.reshape(shots, frames, KINDS, 3, *rest)
    return np.swapaxes(parted, 1, 2).reshape(shots, KINDS, 3 * frames, *rest)


def _slopes(data: PoseData, flown: Flown, theory: Theory) -> tuple[Floats, Floats]:
    """Differentiate by the flights' numbers, over sigma, shape (S, 4, 3 F, 12), and square."""
    response = np.zeros((0, *flown.rotation.shape[1:]))
    if theory.camera:
        response = _camera_response(data, flown, theory)
    times = (plain(flown.timing.position), plain(flown.timing.rotation))
    return slopes_of(times, (flown.turned, flown.jacobian), response, _sigmas(data))


def _camera_response(data: PoseData, flown: Flown, theory: Theory) -> Floats:
    """Return the derivative of apparent by true position, shape (S, F, 2, 3, 3)."""
    here = appear(data, flown.position, theory.camera)
    columns = [
        (appear(data, flown.position + _CAMERA_STEP * axis, theory.camera) - here) / _CAMERA_STEP
        for axis in np.eye(3)
    ]
    return np.stack(columns, axis=-1)
