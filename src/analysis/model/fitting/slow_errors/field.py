"""Errors of the images that change with the place in the field, alike in all shots.

Light that is not quite as learned, or a lens not quite as calibrated, shifts and turns what is seen
of a sphere by smooth functions of its place. A sweep crosses the same places again and again: the
error does not average out, no scatter shows it, and a flight takes its course for motion.

It is a Gaussian field, of a size that the flights show (`SlowErrors.varying_m`, `varying_rad`) and
correlated over a third of a flight's path, which makes rates nearly as wrong as a field can: a
shorter course averages out within a flight, a longer one is the same for all of it and has its
parameters in every fit. What is scored beside a fit, whether an effect, a law or a cell of what is
left, is scored beside this field: as columns with a prior, projected out with all that is fitted.
The field is expanded in the functions that explain most of its variance over the places that were
visited (Karhunen and Loeve, by the method of C. K. I. Williams and M. Seeger, Advances in Neural
Information Processing Systems 13, 682 (2001)).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.normal import inverse
from analysis.model.predict.comparison import KINDS, by_block, weights
from analysis.model.predict.linear import linearise
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

MOST_POINTS = 120
"""Places by which a field is known; they lie much nearer to each other than its course."""
COURSES = 3.0
"""In the path of a flight; from 3 to 5 the slope of a line through the field is within 6 % of the
worst, 1.8 of its size over the flight's time."""
LEFT_OUT = 0.02
"""Share of the variance of the field that its functions may miss."""
LEAST_COURSE_M = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """A smooth random function of place, of size 1, as M functions with amplitudes of size 1.

    Attributes
    ----------
    points
        Places by which it is known, m, shape (N, 3).
    weights
        Of the correlations with them in each function, shape (N, M).
    course_m
        Its correlation over a distance d is exp(-(d / course_m)^2 / 2).
    """

    points: Floats
    weights: Floats
    course_m: float

    @classmethod
    def over(cls, points: Floats, course_m: float) -> Field:
        """Return the field over places (N, 3), its functions those that explain most there."""
        values, vectors = np.linalg.eigh(_correlation(points, points, course_m))
        values, vectors = np.maximum(values[::-1], 0.0), vectors[:, ::-1]
        left = 1.0 - np.cumsum(values) / max(values.sum(), 1e-300)
        count = min(int((left > LEFT_OUT).sum()) + 1, len(points))
        return cls(points, vectors[:, :count] / np.sqrt(values[:count]), course_m)

    @property
    def count(self) -> int:
        """Number of functions."""
        return int(self.weights.shape[1])

    def functions(self, places: Floats) -> Floats:
        """Return the functions at places (..., 3), shape (..., M)."""
        return _correlation(places, self.points, self.course_m) @ self.weights


@dataclass(frozen=True, slots=True, eq=False)
class FieldErrors:
    """Fields of the places and turns that are seen of each sphere too much, along X, Y and Z.

    Attributes
    ----------
    fields
        Of sphere a and of sphere b; none of a plate.
    sizes
        Standard deviations of places, m, and of turns, rad.
    """

    fields: tuple[Field, ...] = ()
    sizes: tuple[float, float] = (0.0, 0.0)

    @property
    def count(self) -> int:
        """Number of columns: each function moves three places and three turns."""
        return 6 * sum(field.count for field in self.fields)

    def beside(self, values: Floats, information: Floats) -> tuple[Floats, Floats]:
        """Return a prior's values and information with those of the amplitudes: 0, and 1."""
        nothing, sure = np.zeros(self.count), np.ones(self.count)
        return np.concatenate([values, nothing]), np.concatenate([information, sure])

    def functions(self, data: PoseData, sphere: int) -> Floats:
        """Return the functions of a sphere's field where it is, shape (S, F, M)."""
        return self.fields[sphere].functions(_places(data)[:, :, sphere])

    def columns(self, data: Data) -> Floats:
        """Return what amplitudes of 1 do to the poses, over sigma, shape (S, 4, 3 F, count)."""
        shots, frames = data.times_s.shape if isinstance(data, PoseData) else (data.count, 0)
        columns = np.zeros((self.count, shots, KINDS, 3 * frames))
        if not isinstance(data, PoseData) or not self.fields:
            return np.moveaxis(columns, 0, -1)
        weight, start = by_block(weights(data)), 0
        for i in range(len(self.fields)):
            functions = np.moveaxis(self.functions(data, i), -1, 0)
            for kind, size in enumerate(self.sizes):
                block = 2 * i + kind
                for axis in range(3):
                    own = columns[start : start + len(functions), :, block, axis::3]
                    own[:] = size * functions * weight[:, block, axis::3]
                    start += len(functions)
        return np.moveaxis(columns, 0, -1)

    def products(self, data: Data, columns: Floats) -> Floats:
        """Return the products of columns over sigma (S, 12 F, P) with these, shape (P, count)."""
        if not isinstance(data, PoseData):
            return np.zeros((columns.shape[2], self.count))
        weighed = columns.reshape(*data.times_s.shape, 2, 6, -1) * weights(data)[..., None]
        found = []
        for i, field in enumerate(self.fields):
            functions = self.functions(data, i).reshape(-1, field.count)
            own = weighed[:, :, i].reshape(len(functions), -1)
            moved = (own.T @ functions).reshape(2, 3, -1, field.count)
            sized = moved * np.array(self.sizes)[:, None, None, None]
            found.append(np.moveaxis(sized, 2, 0).reshape(columns.shape[2], -1))
        return np.concatenate(found, axis=1)


NO_FIELDS = FieldErrors()


def field_errors(data: CampaignData) -> FieldErrors:
    """Return the fields of a campaign; none where no errors that change with the place are stated.

    Which places count is seen in the first part of a campaign: its flights go where all go.
    """
    if isinstance(data, ContactTable) or data.slow.varying_m + data.slow.varying_rad <= 0.0:
        return NO_FIELDS
    first = next(iter(data.parts()))
    moving = 1 if first.on_plate else 2
    course = max(_flight(first) / COURSES, LEAST_COURSE_M)
    fields = tuple(Field.over(_visited(first, i), course) for i in range(moving))
    return FieldErrors(fields, (data.slow.varying_m, data.slow.varying_rad))


def with_field(
    covariance: Floats, field: FieldErrors, parts: Iterable[tuple[Data, ShotStates]], theory: Theory
) -> Floats:
    """Return the covariance (P, P) of a fit's shared parameters with what a field does to them.

    The fit has no part for the field: amplitudes of variance 1 move its parameters by A^-1 C, with
    A^-1 their covariance without it and C the products of both kinds of columns.
    """
    if not field.count:
        return covariance
    between = np.zeros((len(covariance), field.count))
    for part, states in parts:
        line = linearise(part, states, theory)
        free, _, _ = line.without_states()
        between += field.products(part, free if line.shared is None else line.shared.weigh(free))
    moved = covariance @ between
    return np.asarray(covariance + moved @ moved.T)


def explained_by(
    field: FieldErrors, parts: Iterable[tuple[Data, ShotStates]], theory: Theory
) -> float:
    """Return by how much chi-squared falls, the prior of the field in, where the field is fitted.

    What is left has the degrees of freedom of the fit: a prior counts as a measurement of each
    amplitude.
    """
    centre, known = field.beside(*theory.prior)
    information, downhill = np.diag(known), known * (centre - field.beside(theory.vector, known)[0])
    for part, states in parts:
        line = linearise(part, states, theory, given=field.columns(part))
        _, more, further = line.without_states()
        information, downhill = information + more, downhill + further
    return float(downhill @ inverse(information) @ downhill)


def _visited(data: PoseData, sphere: int) -> Floats:
    """Return places of a sphere, evenly taken from all that was measured, shape (N, 3)."""
    seen = np.isfinite(data.position_sigma[:, :, sphere]).any(axis=2)
    places = _places(data)[:, :, sphere][seen]
    return np.asarray(places[:: max(1, -(-len(places) // MOST_POINTS))])


def _places(data: PoseData) -> Floats:
    """Return measured places, 0 where a coordinate is not measured, shape (S, F, 2, 3)."""
    return np.where(np.isfinite(data.position_sigma), data.position, 0.0)


def _flight(data: PoseData) -> float:
    """Return the path of a typical flight, m: half of what a shot's sphere goes."""
    seen = np.asarray(np.isfinite(data.position_sigma[:, :, 0]).all(axis=2))
    steps = np.linalg.norm(np.diff(data.position[:, :, 0], axis=1), axis=2)
    both = seen[:, 1:] & seen[:, :-1]
    return float(np.median(np.where(both, steps, 0.0).sum(axis=1))) / 2.0


def _correlation(places: Floats, points: Floats, course_m: float) -> Floats:
    """Return correlations between places (..., 3) and points (N, 3), shape (..., N)."""
    squares = (
        (places**2).sum(axis=-1)[..., None] + (points**2).sum(axis=-1) - 2.0 * places @ points.T
    )
    return np.asarray(np.exp(-np.maximum(squares, 0.0) / (2.0 * course_m**2)))
