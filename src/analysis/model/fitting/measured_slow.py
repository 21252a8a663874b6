"""How large the slow errors of a campaign's poses are, from all its flights, before any fit.

Where spheres are learned, few films say how large they are (`photometric.slow_size`): six of them
to a third. All flights of a campaign determine it to a tenth. Lines in free flight, with a drag of
the air, and a constant spin are taken out of each flight, and what is left is seen in the next
polynomials of time, of turns in what no start and no spin make: fresh errors have unit variance
there, slow ones a gain that follows from how long they last. In what flights through the same
places agree is a field of errors that all of them share (`field_errors`); how large that is shows
too, and the likeliest one is taken out. No law of contact enters.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from dataclasses import field as field_of
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.field_errors import NO_FIELDS, FieldErrors, field_errors
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
MIDDLE_OF_VARYING = 0.7
"""Of what all flights share, as much changes with the place as does not: prior of its size."""
LEAST_GAIN = 1e-9
ROUNDS = 5
"""Of the fit of a constant spin, from the median of the turns from frame to frame on."""


def with_measured_slow_errors(data: C) -> C:
    """Return a campaign with slow errors of flights as large as its flights show.

    What is stated of them is the prior: one standard error of it is a factor of 2. Where none are
    stated, where no flight is long enough, in tables, and on a plate, they stay as they are.
    """
    if isinstance(data, ContactTable) or data.bodies[1].is_plate or data.slow.position_m <= 0.0:
        return data
    first = next(iter(data.parts()))
    known, field = list(_numbers(first)), field_errors(data)
    factor, off = 1.0, NO_PART
    for _ in range(2):
        seen = [
            film
            for k, part in enumerate(data.parts())
            for film in _films(part, _numbers(part) if k else known, off)
        ]
        if not any(film.squares.size for film in seen):
            return data
        factor = slow_size(seen, 1.0)
        off = _part_of_field(first, known, field, factor) if field.count else NO_PART
    change = partial(_resized, factor=factor, varying=off.size)
    return data.changed(change) if isinstance(data, PoseStream) else change(data)


def _resized(data: PoseData, factor: float, varying: float) -> PoseData:
    stated = data.slow
    slow = replace(
        stated,
        position_m=factor * stated.position_m,
        rotation_rad=factor * stated.rotation_rad,
        shared_m=stated.common_m,
        varying=varying * stated.varying,
    )
    return replace(data, slow=slow)


@dataclass(frozen=True, slots=True, eq=False)
class _Numbers:
    """What flights of one sphere hold beside free flight: K independent numbers of each.

    Attributes
    ----------
    sphere, axes
        Whose; of places along one axis, or of turns about all three.
    shots
        Where the flights are in the part, shape (N,).
    rows
        By which places or turns make the numbers up, shape (N, K, F, axes).
    values, gains
        The numbers, and how much a slow error adds to their variance of 1, shape (N, K).
    """

    sphere: int
    axes: tuple[int, ...]
    shots: NDArray[np.intp]
    rows: Floats
    values: Floats
    gains: Floats

    def by_field(self, data: PoseData, field: FieldErrors) -> Floats:
        """Return what the field's amplitudes add to the numbers, shape (N, K, amplitudes)."""
        size = field.sizes[0 if len(self.axes) == 1 else 1]
        functions = field.functions(data, self.sphere)[self.shots]
        moved = np.einsum("nkfa,nfm->nkam", self.rows, functions, optimize=True)
        return np.asarray(size * moved.reshape(*self.values.shape, -1))


@dataclass(frozen=True, slots=True, eq=False)
class _PartOfField:
    """How large a field of errors is, over what all flights share, and its likeliest amplitudes.

    By sphere and axes.
    """

    field: FieldErrors = NO_FIELDS
    size: float = 1.0
    amplitudes: Mapping[tuple[int, tuple[int, ...]], Floats] = field_of(default_factory=dict)

    def less(self, numbers: _Numbers, data: PoseData) -> Floats:
        """Return numbers less what the field does to them, shape (N, K)."""
        own = self.amplitudes.get((numbers.sphere, numbers.axes))
        if own is None:
            return numbers.values
        return np.asarray(numbers.values - numbers.by_field(data, self.field) @ own)


NO_PART = _PartOfField()


def _part_of_field(
    data: PoseData, known: Iterable[_Numbers], field: FieldErrors, factor: float
) -> _PartOfField:
    """Return how large the field is by what the flights of a part of a campaign agree in."""
    sums: dict[tuple[int, tuple[int, ...]], list[Floats]] = {}
    for numbers in known:
        columns = numbers.by_field(data, field)
        weight = 1.0 / (1.0 + factor**2 * numbers.gains)
        own = sums.setdefault((numbers.sphere, numbers.axes), [np.zeros(()), np.zeros(())])
        own[0] = own[0] + np.einsum("nkp,nk,nkq->pq", columns, weight, columns, optimize=True)
        own[1] = own[1] + np.einsum("nkp,nk->p", columns, weight * numbers.values)
    solved = {name: (*np.linalg.eigh(matrix), right) for name, (matrix, right) in sums.items()}
    gains = np.concatenate([values for values, _, _ in solved.values()] or [np.empty(0)])
    along = [vectors.T @ right for _, vectors, right in solved.values()]
    squares = np.concatenate([own**2 for own in along] or [np.empty(0)])
    seen = gains > LEAST_GAIN
    evidence = Evidence(gains[seen], squares[seen] / gains[seen])
    size = slow_size([evidence], MIDDLE_OF_VARYING)
    amplitudes = {
        name: vectors @ (vectors.T @ right / (np.maximum(values, 0.0) + size**-2))
        for name, (values, vectors, right) in solved.items()
    }
    return _PartOfField(field, size, amplitudes)


def _films(data: PoseData, known: Iterable[_Numbers], off: _PartOfField) -> Iterator[Evidence]:
    """Yield what each shot of a part shows of its slow errors, in units of those stated.

    Less what a field of errors does.
    """
    gains: list[list[Floats]] = [[np.empty(0)] for _ in data.shots]
    squares: list[list[Floats]] = [[np.empty(0)] for _ in data.shots]
    for numbers in known:
        values = off.less(numbers, data)
        for row, gain, value in zip(numbers.shots, numbers.gains, values, strict=True):
            gains[row].append(gain)
            squares[row].append(value**2)
    for own in zip(gains, squares, strict=True):
        yield Evidence(*(np.concatenate(part) for part in own))


def _numbers(data: PoseData) -> Iterator[_Numbers]:
    """Yield what all flights of a part hold beside free flight."""
    times = data.times_s - first_states(data).time_s[:, None]
    for later in (False, True):
        for sphere in (0, 1):
            turned = np.isfinite(data.rotation_sigma[:, :, sphere])
            placed = np.isfinite(data.position_sigma[:, :, sphere]).all(axis=2)
            seen = placed & turned & ((times > 0) == later)
            shots = np.flatnonzero(seen.sum(axis=1) >= LEAST_FRAMES)
            if shots.size:
                spin = median_spin(data, seen[..., None] & (np.arange(2) == sphere))[shots, sphere]
                yield from _of_flights(data, times, seen, (sphere, shots), spin)


def _of_flights(
    data: PoseData,
    times: Floats,
    seen: NDArray[np.bool_],
    which: tuple[int, NDArray[np.intp]],
    first_spin: Floats,
) -> Iterator[_Numbers]:
    """Yield the numbers of one sphere on one side in some shots, first of places, then of turns."""
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
    place_sigma = data.position_sigma[shots, :, sphere]
    for axis in range(3):
        weight = _weights(place_sigma[..., axis], seen)
        basis = np.linalg.qr(functions * weight[..., None])[0][..., BENT:]
        seen_there = (fallen[..., axis, None], weight[..., None], data.slow.position_m)
        yield _Numbers(sphere, (axis,), shots, *_independent(basis, seen_there, lasting))
    weight = np.repeat(_weights(data.rotation_sigma[shots, :, sphere], seen)[..., None], 3, axis=2)
    bent = np.kron(functions[..., STRAIGHT:], np.eye(3)).reshape(*left.shape, -1)
    columns = np.concatenate([_slopes(spin, tau), bent], axis=3) * weight[..., None]
    basis = np.linalg.qr(columns.reshape(len(shots), -1, columns.shape[3]))[0][..., SPUN:]
    seen_there = (left, weight, data.slow.rotation_rad)
    yield _Numbers(sphere, (0, 1, 2), shots, *_independent(basis, seen_there, lasting))


def _weights(sigma: Floats, seen: NDArray[np.bool_]) -> Floats:
    return np.where(seen, 1.0 / np.where(seen, sigma, 1.0), 0.0)


def _independent(
    basis: Floats, measured: tuple[Floats, Floats, float], lasting: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return rows, values and gains of what some directions of each flight hold.

    Parameters
    ----------
    basis
        Orthonormal directions, shape (N, F A, K), of A axes in each frame.
    measured
        Values and their weights, shape (N, F, A), and the size of the slow error.
    lasting
        Correlation of slow errors between frames, shape (N, F, F).
    """
    values, weight, size = measured
    slow = size * weight[..., None] * basis.reshape(*weight.shape, -1)
    carried = np.einsum("nfg,ngak->nfak", lasting, slow, optimize=True).reshape(basis.shape)
    spread, vectors = np.linalg.eigh(np.swapaxes(slow.reshape(basis.shape), 1, 2) @ carried)
    turned = np.swapaxes(basis @ vectors, 1, 2)
    rows = turned.reshape(*turned.shape[:2], *weight.shape[1:]) * weight[:, None]
    found = np.einsum("nkfa,nfa->nk", rows, values, optimize=True)
    return rows, found, np.maximum(spread, 0.0)


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
