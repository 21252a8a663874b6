"""How large the slow errors of a campaign's poses are, from all its flights, before any fit.

Where spheres are learned, few films say how large they are (`photometric.slow_size`): six of them
to a third. All flights of a campaign determine it to a tenth, by what free flights leave of poses
(`flight_numbers`). Z is seen in another view than X and Y, and turns by the markers: each of these
three kinds has a size of its own, near that of all. In what flights through the same places agree
is a field of errors that all of them share (`field_errors`); how large that is shows too, and the
likeliest one is taken out, with its error. No law of contact enters.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from dataclasses import field as field_of
from functools import partial
from typing import TypeVar

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.slow_errors.field import field_errors
from analysis.model.fitting.slow_errors.flight_numbers import TURNS, FlightNumbers, flight_numbers
from analysis.motion.slow_evidence import Evidence, slow_size

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
