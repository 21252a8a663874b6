"""How large the slow errors of a campaign's poses are, from all its flights, before any fit.

Where spheres are learned, few films say how large they are (`photometric.slow_size`): six of them
to a third. All flights of a campaign determine it to a tenth. Lines in free flight, with a drag of
the air, and a constant spin are taken out of each flight, and what is left is seen in the next
polynomials of time, of turns in what no start and no spin make: fresh errors have unit variance
there, slow ones a gain that follows from how long they last. No law of contact enters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable, Data
from analysis.model.predict.start import first_states, median_spin
from analysis.motion.drift import correlation_times
from analysis.motion.exponential import exponential
from analysis.motion.rotation import rotation_matrix, rotation_vector
from analysis.motion.slow_evidence import Evidence, slow_size

C = TypeVar("C", PoseData, ContactTable, PoseStream, Data, CampaignData)

DEGREE = 6
"""Of the polynomials, the highest."""
BENT, STRAIGHT = 3, 2
"""Polynomials that a free flight takes of places (a line and the drag's bend), and of turns."""
SPUN = 6
"""Numbers of a flight's turns: an orientation and a spin."""
LEAST_FRAMES = DEGREE + 3
ROUNDS = 5
"""Of the fit of a constant spin, from the median of the turns from frame to frame on."""


def with_measured_slow_errors(data: C) -> C:
    """Return a campaign with slow errors of flights as large as its flights show.

    What is stated of them is the prior: one standard error of it is a factor of 2. Where none are
    stated, where no flight is long enough, in tables, and on a plate, they stay as they are.
    """
    if isinstance(data, ContactTable) or data.bodies[1].is_plate or data.slow.position_m <= 0.0:
        return data
    seen = [film for part in data.parts() for film in _films(part)]
    if not any(film.squares.size for film in seen):
        return data
    change = partial(_resized, factor=slow_size(seen, 1.0))
    return data.changed(change) if isinstance(data, PoseStream) else change(data)


def _resized(data: PoseData, factor: float) -> PoseData:
    stated = data.slow
    position, rotation = factor * stated.position_m, factor * stated.rotation_rad
    slow = replace(stated, position_m=position, rotation_rad=rotation, shared_m=stated.common_m)
    return replace(data, slow=slow)


def _films(data: PoseData) -> Iterator[Evidence]:
    """Yield what each shot of a part shows of its slow errors, in units of those stated."""
    times = data.times_s - first_states(data).time_s[:, None]
    gains: list[list[Floats]] = [[np.empty(0)] for _ in data.shots]
    squares: list[list[Floats]] = [[np.empty(0)] for _ in data.shots]
    for later in (False, True):
        for sphere in (0, 1):
            turned = np.isfinite(data.rotation_sigma[:, :, sphere])
            placed = np.isfinite(data.position_sigma[:, :, sphere]).all(axis=2)
            seen = placed & turned & ((times > 0) == later)
            shots = np.flatnonzero(seen.sum(axis=1) >= LEAST_FRAMES)
            if shots.size:
                spin = median_spin(data, seen[..., None] & (np.arange(2) == sphere))[shots, sphere]
                for found, into in zip(
                    _of_flights(data, times, seen, (sphere, shots), spin),
                    (gains, squares),
                    strict=True,
                ):
                    for row, own in zip(shots, found, strict=True):
                        into[row].append(own)
    for own in zip(gains, squares, strict=True):
        yield Evidence(*(np.concatenate(part) for part in own))


def _of_flights(
    data: PoseData,
    times: Floats,
    seen: NDArray[np.bool_],
    which: tuple[int, NDArray[np.intp]],
    first_spin: Floats,
) -> tuple[Floats, Floats]:
    """Return gains and squares of one sphere on one side, some shots, shape (N, numbers)."""
    sphere, shots = which
    seen, tau = seen[shots], times[shots]
    first = np.where(seen, tau, np.inf).min(axis=1, keepdims=True)
    last = np.where(seen, tau, -np.inf).max(axis=1, keepdims=True)
    place = np.where(seen, 2.0 * (tau - first) / (last - first) - 1.0, 0.0)
    functions = np.polynomial.legendre.legvander(place, DEGREE)
    left, spin = _turns(data.rotation[shots, :, sphere], tau, seen, first_spin)
    fallen = data.position[shots, :, sphere].copy()
    fallen[..., 0] -= 0.5 * data.gravity * tau**2
    lasting_s = correlation_times(data.slow.memory_rad, np.linalg.norm(spin, axis=1))
    apart = np.abs(tau[:, :, None] - tau[:, None, :])
    lasting = np.exp(-apart / lasting_s[:, None, None])
    gains: list[Floats] = []
    squares: list[Floats] = []
    place_sigma = data.position_sigma[shots, :, sphere]
    for axis in range(3):
        weight = _weights(place_sigma[..., axis], seen)
        basis = np.linalg.qr(functions * weight[..., None])[0][..., BENT:]
        values = (fallen[..., axis] * weight)[..., None]
        _add(gains, squares, basis, (values, weight[..., None], data.slow.position_m), lasting)
    weight = np.repeat(_weights(data.rotation_sigma[shots, :, sphere], seen)[..., None], 3, axis=2)
    bent = np.kron(functions[..., STRAIGHT:], np.eye(3)).reshape(*left.shape, -1)
    columns = np.concatenate([_slopes(spin, tau), bent], axis=3) * weight[..., None]
    basis = np.linalg.qr(columns.reshape(len(shots), -1, columns.shape[3]))[0][..., SPUN:]
    _add(gains, squares, basis, (left * weight, weight, data.slow.rotation_rad), lasting)
    return np.concatenate(gains, axis=1), np.concatenate(squares, axis=1)


def _weights(sigma: Floats, seen: NDArray[np.bool_]) -> Floats:
    return np.where(seen, 1.0 / np.where(seen, sigma, 1.0), 0.0)


def _add(
    gains: list[Floats],
    squares: list[Floats],
    basis: Floats,
    measured: tuple[Floats, Floats, float],
    lasting: Floats,
) -> None:
    """Add what some directions of each flight hold, turned to independent numbers.

    Parameters
    ----------
    basis
        Orthonormal directions, shape (N, F A, K), of A axes in each frame.
    measured
        Whitened values and their weights, shape (N, F, A), and the size of the slow error.
    lasting
        Correlation of slow errors between frames, shape (N, F, F).
    """
    values, weight, size = measured
    slow = size * weight[..., None] * basis.reshape(*weight.shape, -1)
    carried = np.einsum("nfg,ngak->nfak", lasting, slow, optimize=True).reshape(basis.shape)
    spread, vectors = np.linalg.eigh(np.swapaxes(slow.reshape(basis.shape), 1, 2) @ carried)
    found = np.swapaxes(basis, 1, 2) @ values.reshape(len(basis), -1, 1)
    squares.append((np.swapaxes(vectors, 1, 2) @ found)[..., 0] ** 2)
    gains.append(np.maximum(spread, 0.0))


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
