"""What free flights leave of poses, as independent numbers in which slow errors show.

Lines in free flight, with a drag of the air, and a constant spin are taken out of each flight, and
what is left is seen in the next polynomials of time, of turns in what no start and no spin make:
fresh errors have unit variance there, slow ones a gain that follows from how long they last.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.data.poses import PoseData
from analysis.model.fitting.slow_errors.field import FieldErrors
from analysis.model.predict.start import first_states, median_spin
from analysis.motion.drift import correlation_times
from analysis.motion.exponential import exponential
from analysis.motion.rotation import rotation_matrix, rotation_vector

DEGREES = {9: 6, 15: 12}
"""The highest of the polynomials, by the fewest frames of a flight; shorter ones are left out."""
BENT, STRAIGHT = 3, 2
"""Polynomials that a free flight takes of places (a line and the drag's bend), and of turns."""
SPUN = 6
"""Numbers of a flight's turns: an orientation and a spin."""
ROUNDS = 5
"""Of the fit of a constant spin, from the median of the turns from frame to frame on."""
TURNS = 0, 1, 2
"""Axes of numbers of turns."""


@dataclass(frozen=True, slots=True, eq=False)
class FlightNumbers:
    """What flights of one sphere hold beside free flight: K independent numbers of each.

    Attributes
    ----------
    sphere, axes
        Whose; of places along one axis, or of turns about all three.
    shots
        Where the flights are in the part, shape (N,).
    values, gains
        The numbers, and how much a slow error adds to their variance of 1, shape (N, K).
    by_field
        What amplitudes of a field of errors add to the numbers, shape (N, K, amplitudes).
    """

    sphere: int
    axes: tuple[int, ...]
    shots: NDArray[np.intp]
    values: Floats
    gains: Floats
    by_field: Floats


def flight_numbers(data: PoseData, field: FieldErrors) -> Iterator[FlightNumbers]:
    """Yield what all flights of a part of a campaign leave, beside the amplitudes of a field."""
    times = data.times_s - first_states(data).time_s[:, None]
    for sphere in (0, 1):
        functions = field.functions(data, sphere) if field.fields else np.zeros((*times.shape, 0))
        turned = np.isfinite(data.rotation_sigma[:, :, sphere])
        measured = turned & np.isfinite(data.position_sigma[:, :, sphere]).all(axis=2)
        for later in (False, True):
            seen = measured & ((times > 0) == later)
            spins = median_spin(data, seen[..., None] & (np.arange(2) == sphere))[:, sphere]
            length = np.searchsorted(list(DEGREES), seen.sum(axis=1), side="right")
            for k, degree in enumerate(DEGREES.values(), 1):
                own = np.flatnonzero(length == k)
                if own.size:
                    flights = _Flights(data, sphere, own, times[own], seen[own], spins[own])
                    yield from flights.numbers(degree, (field.sizes, functions[own]))


@dataclass(frozen=True, slots=True, eq=False)
class _Flights:
    """N flights of one sphere on one side of the contact.

    Attributes
    ----------
    shots
        Where they are in the data, shape (N,).
    times_s, seen
        Of the contact's, and whether a frame belongs to the flight, shape (N, F).
    spins
        First guesses, rad/s, shape (N, 3).
    """

    data: PoseData
    sphere: int
    shots: NDArray[np.intp]
    times_s: Floats
    seen: NDArray[np.bool_]
    spins: Floats

    def numbers(
        self, degree: int, field: tuple[tuple[float, float], Floats]
    ) -> Iterator[FlightNumbers]:
        """Yield numbers of places along each axis, then of turns.

        Parameters
        ----------
        degree
            The highest of the polynomials.
        field
            Sizes of a field of errors, m and rad, and its functions, shape (N, F, M).
        """
        functions, sizes = self._polynomials(degree), self.data.slow.sizes
        turns, spin = _turns(self._of(self.data.rotation), self.times_s, self.seen, self.spins)
        lasting_s = correlation_times(self.data.slow.memory_rad, np.linalg.norm(spin, axis=1))
        apart = np.abs(self.times_s[:, :, None] - self.times_s[:, None, :])
        lasting = np.exp(-apart / lasting_s[:, None, None])
        places, place_sigma = self._places(), self._of(self.data.position_sigma)
        for axis in range(3):
            weight = self._weights(place_sigma[..., axis, None])
            basis = np.linalg.qr(functions * weight)[0][..., BENT:]
            seen = places[..., axis, None], weight, sizes[0][axis]
            own = _independent(basis, seen, lasting, (field[0][0], field[1]))
            yield FlightNumbers(self.sphere, (axis,), self.shots, *own)
        weight = self._weights(self._of(self.data.turn_sigma))
        bent = np.kron(functions[..., STRAIGHT:], np.eye(3)).reshape(*turns.shape, -1)
        taken = np.concatenate([_slopes(spin, self.times_s), bent], axis=3) * weight[..., None]
        basis = np.linalg.qr(taken.reshape(len(self.shots), -1, taken.shape[3]))[0][..., SPUN:]
        own = _independent(basis, (turns, weight, sizes[1][0]), lasting, (field[0][1], field[1]))
        yield FlightNumbers(self.sphere, TURNS, self.shots, *own)

    def _of(self, poses: Floats) -> Floats:
        return np.asarray(poses[self.shots, :, self.sphere])

    def _weights(self, sigma: Floats) -> Floats:
        seen = self.seen[..., None]
        return np.where(seen, 1.0 / np.where(seen, sigma, 1.0), 0.0)

    def _polynomials(self, degree: int) -> Floats:
        """Return Legendre polynomials over the time of each flight, shape (N, F, degree + 1)."""
        first = np.where(self.seen, self.times_s, np.inf).min(axis=1, keepdims=True)
        last = np.where(self.seen, self.times_s, -np.inf).max(axis=1, keepdims=True)
        within = 2.0 * (self.times_s - first) / (last - first) - 1.0
        within = np.where(self.seen, within, 0.0)
        return np.asarray(np.polynomial.legendre.legvander(within, degree), dtype=np.float64)

    def _places(self) -> Floats:
        """Return places without the fall, m, shape (N, F, 3)."""
        fallen = self._of(self.data.position).copy()
        fallen[..., 0] -= 0.5 * self.data.gravity * self.times_s**2
        return fallen


def _independent(
    basis: Floats,
    measured: tuple[Floats, Floats, float],
    lasting: Floats,
    field: tuple[float, Floats],
) -> tuple[Floats, Floats, Floats]:
    """Return values, gains and the share of a field of what some directions of each flight hold.

    Parameters
    ----------
    basis
        Orthonormal directions, shape (N, F A, K), of A axes in each frame.
    measured
        Values and their weights, shape (N, F, A), and the size of the slow error.
    lasting
        Correlation of slow errors between frames, shape (N, F, F).
    field
        Size of a field of errors, and its functions, shape (N, F, M).
    """
    values, weight, size = measured
    slow = size * weight[..., None] * basis.reshape(*weight.shape, -1)
    carried = np.einsum("nfg,ngak->nfak", lasting, slow, optimize=True).reshape(basis.shape)
    spread, vectors = np.linalg.eigh(np.swapaxes(slow.reshape(basis.shape), 1, 2) @ carried)
    turned = np.swapaxes(basis @ vectors, 1, 2)
    rows = turned.reshape(*turned.shape[:2], *weight.shape[1:]) * weight[:, None]
    found = np.einsum("nkfa,nfa->nk", rows, values, optimize=True)
    by_field = field[0] * np.einsum("nkfa,nfm->nkam", rows, field[1], optimize=True)
    return found, np.maximum(spread, 0.0), by_field.reshape(*found.shape, -1)


def _slopes(spin: Floats, since: Floats) -> Floats:
    """Return slopes of turns by a start's small turn and by the spin, shape (N, F, 3, 6)."""
    turned, jacobian = exponential(spin[:, None] * since[..., None])
    return np.concatenate([turned, since[..., None, None] * jacobian], axis=3)


def _turns(
    rotation: Floats, tau: Floats, seen: NDArray[np.bool_], spin: Floats
) -> tuple[Floats, Floats]:
    """Return what a constant spin leaves of turns (N, F, 3), rad, and the spin (N, 3), rad/s.

    `spin` is the first guess of it.
    """
    middle = (tau * seen).sum(axis=1) / seen.sum(axis=1)
    nearest = np.where(seen, np.abs(tau - middle[:, None]), np.inf).argmin(axis=1)
    rows = np.arange(len(tau))
    at_middle, since = rotation[rows, nearest], tau - middle[:, None]
    start = rotation_matrix(-spin * since[rows, nearest][:, None]) @ at_middle
    ones = seen[..., None]
    for _ in range(ROUNDS):
        expected = rotation_matrix(spin[:, None] * since[..., None]) @ start[:, None]
        left = np.where(ones, rotation_vector(rotation @ np.swapaxes(expected, 2, 3)), 0.0)
        columns = (_slopes(spin, since) * ones[..., None]).reshape(len(tau), -1, SPUN)
        across = np.swapaxes(columns, 1, 2)
        right = across @ left.reshape(len(tau), -1, 1)
        step = np.asarray(np.linalg.solve(across @ columns, right)[..., 0], dtype=np.float64)
        start, spin = rotation_matrix(step[:, :3]) @ start, spin + step[:, 3:]
    return left, spin
