"""How large the slow errors of a campaign's poses are, from all its flights, before any fit.

Where spheres are learned, few films say how large they are (`photometric.slow_size`): six of them
to a third. All flights of a campaign determine it to a tenth, by what free flights leave of poses.
Lines in free flight, with a drag of the air, and a constant spin are taken out of each flight, and
what is left is seen in the next polynomials of time, of turns in what no start and no spin make:
fresh errors have unit variance there, slow ones a gain that follows from how long they last. Z is
seen in another view than X and Y, and turns by the markers: each of these three kinds has a size of
its own, near that of all. In what flights through the same places agree is a field of errors that
all of them share (`field_errors`); how large that is shows too, and the likeliest one is taken out,
with its error. No law of contact enters.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
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
from analysis.model.fitting.slow_errors.field import FieldErrors, field_errors
from analysis.model.predict.start import first_states, median_spin
from analysis.motion.drift import correlation_times
from analysis.motion.exponential import exponential
from analysis.motion.rotation import rotation_matrix, rotation_vector
from analysis.motion.slow_evidence import Evidence, slow_size

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


C = TypeVar("C", PoseData, ContactTable, PoseStream, Data, CampaignData)

KINDS = ((0,), (1,)), ((2,),), (TURNS,)
"""Of numbers whose slow errors are of one size, by their axes: one of places, or all of turns."""
APART = 1.5
"""One standard error of what the size of a kind is over that of all."""
MIDDLE_OF_VARYING = 0.7
"""Of what all flights share, as much changes with the place as does not: prior of its size."""
LEAST_GAIN = 1e-9


def with_measured_slow_errors(data: C) -> C:
    """Return a campaign with slow errors of flights as large as its flights show.

    What is stated of them is the prior: one standard error of it is a factor of 2. Where none are
    stated, where no flight is long enough, in tables, and on a plate, they stay as they are.
    """
    if isinstance(data, ContactTable) or data.bodies[1].is_plate or data.slow.position_m <= 0.0:
        return data
    field, factors, off = field_errors(data), Factors(), NO_PART
    known = list(flight_numbers(next(iter(data.parts())), field))
    for _ in range(2):
        films = [
            film
            for k, part in enumerate(data.parts())
            for film in _films(part, flight_numbers(part, field) if k else known, off)
        ]
        if not any(own.squares.size for film in films for own in film):
            return data
        factors = Factors.of(films)
        off = _part_of_field(known, factors) if field.count else NO_PART
    change = partial(_resized, factors=factors, varying=off.size)
    return data.changed(change) if isinstance(data, PoseStream) else change(data)


@dataclass(frozen=True, slots=True)
class Factors:
    """How large slow errors are over what is stated: of X and Y, of Z, and of turns."""

    places: float = 1.0
    depth: float = 1.0
    turns: float = 1.0

    @classmethod
    def of(cls, films: Sequence[Sequence[Evidence]]) -> Factors:
        """Return those that films show of the three `KINDS`: each near that of all together."""
        joint = slow_size([Evidence.joined(film) for film in films], 1.0)
        return cls(*(slow_size(own, joint, APART) for own in zip(*films, strict=True)))

    def by_axes(self, axes: tuple[int, ...]) -> float:
        """Return that of numbers of these axes."""
        return (self.places, self.depth, self.turns)[_kind_of(axes)]


def _kind_of(axes: tuple[int, ...]) -> int:
    return next(k for k, kind in enumerate(KINDS) if axes in kind)


def _resized(data: PoseData, factors: Factors, varying: float) -> PoseData:
    stated = data.slow
    slow = replace(
        stated,
        position_m=factors.places * stated.position_m,
        depth_m=factors.depth * (stated.depth_m or stated.position_m),
        rotation_rad=factors.turns * stated.rotation_rad,
        shared_m=stated.common_m,
        shared_rad=stated.common_rad,
        varying=varying * stated.varying,
    )
    return replace(data, slow=slow)


@dataclass(frozen=True, slots=True, eq=False)
class _PartOfField:
    """How large a field of errors is, over what all flights share, and its likeliest amplitudes.

    By sphere and axes, with their covariance.
    """

    size: float = 1.0
    amplitudes: Mapping[tuple[int, tuple[int, ...]], tuple[Floats, Floats]] = field_of(
        default_factory=dict
    )

    def squares(self, numbers: FlightNumbers) -> Floats:
        """Return expected squares of numbers without what the field does to them, shape (N, K).

        The likeliest field has taken some of them with it: what is not known of it is added.
        """
        if (numbers.sphere, numbers.axes) not in self.amplitudes:
            return np.square(numbers.values)
        likely, covariance = self.amplitudes[numbers.sphere, numbers.axes]
        columns = numbers.by_field
        unsure = np.einsum("nkp,pq,nkq->nk", columns, covariance, columns, optimize=True)
        return np.asarray((numbers.values - columns @ likely) ** 2 + unsure)


NO_PART = _PartOfField()


def _part_of_field(known: Iterable[FlightNumbers], factors: Factors) -> _PartOfField:
    """Return how large the field is by what the flights of a part of a campaign agree in."""
    sums: dict[tuple[int, tuple[int, ...]], list[Floats]] = {}
    for numbers in known:
        columns = numbers.by_field
        weight = 1.0 / (1.0 + factors.by_axes(numbers.axes) ** 2 * numbers.gains)
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
    amplitudes = {}
    for name, (values, vectors, right) in solved.items():
        covariance = (vectors / (np.maximum(values, 0.0) + size**-2)) @ vectors.T
        amplitudes[name] = covariance @ right, covariance
    return _PartOfField(size, amplitudes)


def _films(
    data: PoseData, known: Iterable[FlightNumbers], off: _PartOfField
) -> Iterator[tuple[Evidence, ...]]:
    """Yield what each shot of a part shows of its slow errors of each of the `KINDS`.

    In units of those stated, less what a field of errors does.
    """
    seen: list[list[list[Evidence]]] = [[[] for _ in KINDS] for _ in data.shots]
    for numbers in known:
        kind = _kind_of(numbers.axes)
        own = zip(numbers.shots, numbers.gains, off.squares(numbers), strict=True)
        for row, gains, squares in own:
            seen[row][kind].append(Evidence(gains, squares))
    for shot in seen:
        yield tuple(Evidence.joined(kind) for kind in shot)
