"""The two flights of every shot as its own poses, or its row of a table, have them: no law enters.

About a fitted campaign the data are nearly linear in the 48 numbers of the flights
(`analysis.model.predict.sides`), so that one step sets them free of the law. What shots share of
errors (scale, drag, offsets) stays where it is stated, and what one standard error of it does is
told.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Body, Encounter, Operator, States
from analysis.model.data.tables import ContactTable, Data
from analysis.model.predict.columns import systematic_columns
from analysis.model.predict.comparison import compare
from analysis.model.predict.sides import NUMBERS, Flights
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

LEAST_INFORMATION = 1e-9
"""Of the largest in its block, each scaled to one: less is the rounding of what was not seen."""
NOWHERE = 1.0
"""Variance of a place, m^2, beyond which flights have none."""
UNSEEN = 1e6
"""Standard error, m, m/s or rad/s, of what was not measured."""
AT_REST = 1e-9
"""Standard error, m/s and rad/s, of a plate."""
OF_PLATE = np.array([9, 10, 11, 15, 16, 17])
"""Velocity and spin of b among the numbers of a side."""
SIDE = 18
"""Numbers of one side of a contact: places of a and b, velocities, and spins."""


@dataclass(frozen=True, slots=True, eq=False)
class FreeFlights:
    """Both sides of S contacts, extrapolated to one instant near first touch.

    Attributes
    ----------
    before, after
        Places of a and b (m), velocities (m/s) and spins (rad/s), shape (S, 18).
    before_covariance, after_covariance
        Of these, shape (S, 18, 18).
    before_shared, after_shared
        What one standard error of each thing that all shots share does to them, shape (S, 18, K).
    bodies, covariates
        As an `Encounter` has them.
    measured_s
        How long contacts last where that is tabulated, s, shape (S,); else not a number.
    """

    before: Floats
    after: Floats
    before_covariance: Floats
    after_covariance: Floats
    before_shared: Floats
    after_shared: Floats
    bodies: tuple[Body, Body]
    covariates: dict[str, Floats]
    measured_s: Floats

    def encounter(self, before: Floats, e: Floats, mu: float | Floats) -> tuple[Encounter, Floats]:
        """Return the encounters that flights before contact (N, 18) lead to, and when, s, (N,).

        Parameters
        ----------
        before
            Of all shots, once or several times over.
        e, mu
            Restitution of each, shape (N,), and the friction of each or of all.
        """
        places, velocities, spins = (before.reshape(-1, 3, 2, 3)[:, k] for k in range(3))
        gap, closing = places[:, 1] - places[:, 0], velocities[:, 1] - velocities[:, 0]
        reach = self.bodies[0].radius + self.bodies[1].radius
        wait = time_at_distance(gap, closing, reach, -1.0)
        count = len(before)
        encounter = Encounter(
            States(velocities[:, 0], velocities[:, 1], spins[:, 0], spins[:, 1]),
            (gap + closing * wait[:, None]) / reach,
            self.bodies,
            e,
            np.array(np.broadcast_to(mu, count)),
            np.zeros(count),
            _Repeated(self.covariates, count),
        )
        return encounter, wait

    def foretold(self, before: Floats, operator: Operator, e: Floats, mu: float | Floats) -> Floats:
        """Return the flights after contact that an operator makes of those before, (N, 18)."""
        encounter, wait = self.encounter(before, e, mu)
        outcome = operator(encounter)
        after = outcome.after
        places, speeds = (before.reshape(-1, 3, 2, 3)[:, k] for k in (0, 1))
        flown = np.empty((len(before), 3, 2, 3))
        flown[:, 1, 0], flown[:, 1, 1] = after.velocity_a, after.velocity_b
        flown[:, 2, 0], flown[:, 2, 1] = after.spin_a, after.spin_b
        flown[:, 0, 0], flown[:, 0, 1] = outcome.shift_a, outcome.shift_b
        flown[:, 0] += places + speeds * wait[:, None, None]
        flown[:, 0] -= flown[:, 1] * (wait + outcome.duration)[:, None, None]
        return flown.reshape(-1, SIDE)

    @property
    def spins_seen(self) -> NDArray[np.bool_]:
        """Return which contacts have all spins before and after measured, shape (S,)."""
        variances = [
            np.diagonal(c, axis1=1, axis2=2)[:, 12:]
            for c in (self.before_covariance, self.after_covariance)
        ]
        return np.asarray((np.concatenate(variances, axis=1) < 0.5 * UNSEEN**2).all(axis=1))

    def durations(self) -> Floats:
        """Return how long contacts last, s, (S,): not a number where neither paths nor rows say."""
        if np.isfinite(self.measured_s).any():
            return self.measured_s
        if self.after_covariance[0, 0, 0] > NOWHERE:
            return np.full(len(self.after), np.nan)
        reach = self.bodies[0].radius + self.bodies[1].radius
        times = []
        for side, sign in ((self.before, -1.0), (self.after, 1.0)):
            places, velocities, _ = np.moveaxis(side.reshape(-1, 3, 2, 3), 1, 0)
            gap, relative = places[:, 1] - places[:, 0], velocities[:, 1] - velocities[:, 0]
            times.append(time_at_distance(gap, relative, reach, sign))
        return np.asarray(times[1] - times[0])

    @classmethod
    def joined(cls, parts: Sequence[FreeFlights]) -> FreeFlights:
        """Return those of shots that follow each other in parts."""
        names = set.intersection(*(set(p.covariates) for p in parts))
        return cls(
            np.concatenate([p.before for p in parts]),
            np.concatenate([p.after for p in parts]),
            np.concatenate([p.before_covariance for p in parts]),
            np.concatenate([p.after_covariance for p in parts]),
            np.concatenate([p.before_shared for p in parts]),
            np.concatenate([p.after_shared for p in parts]),
            parts[0].bodies,
            {name: np.concatenate([p.covariates[name] for p in parts]) for name in names},
            np.concatenate([p.measured_s for p in parts]),
        )

    def of_shots(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> FreeFlights:
        """Return those of some shots."""
        return FreeFlights(
            self.before[rows],
            self.after[rows],
            self.before_covariance[rows],
            self.after_covariance[rows],
            self.before_shared[rows],
            self.after_shared[rows],
            self.bodies,
            {name: own[rows] for name, own in self.covariates.items()},
            self.measured_s[rows],
        )


class _Repeated(Mapping[str, Floats]):
    """Covariates of all shots, once or several times over, repeated where an effect asks."""

    def __init__(self, covariates: Mapping[str, Floats], count: int) -> None:
        self._covariates, self._count = covariates, count

    def __getitem__(self, name: str) -> Floats:
        return np.resize(self._covariates[name], self._count)

    def __iter__(self) -> Iterator[str]:
        return iter(self._covariates)

    def __len__(self) -> int:
        return len(self._covariates)


def spread_flights(
    parts: Iterable[tuple[Data, ShotStates]], theory: Theory, shots: int, most: int
) -> FreeFlights:
    """Set the flights of so many shots at most free, spread over all parts of a campaign."""
    chosen = np.zeros(shots, dtype=np.bool_)
    chosen[np.linspace(0, shots - 1, min(shots, most)).round().astype(np.intp)] = True
    found, start = list[FreeFlights](), 0
    for data, states in parts:
        own = chosen[start : start + len(data.shots)]
        start += len(data.shots)
        if own.any():
            found.append(free_flights(data.of_shots(own), states.of_shots(own), theory))
    return FreeFlights.joined(found)


def free_flights(data: Data, states: ShotStates, theory: Theory) -> FreeFlights:
    """Set the flights of every shot free, about states that a fit has found.

    Shots whose paths before contact do not touch, or do not approach, are left out.
    """
    calibrated = tuple(replace(s, values=s.stated) for s in theory.systematics)
    about = replace(theory, systematics=calibrated)
    measured_s = np.full(len(data.shots), np.nan)
    if isinstance(data, ContactTable):
        # A duration alone says nothing of where either body is.
        measured_s, data = data.durations_s, data.without_durations()
    else:
        data = replace(data, jitter_s=0.0)
    line, here = compare(data, states, about)
    blocks = pseudo_inverse(line.gram)
    pulled = line.pulled.reshape(len(data.shots), line.gram.shape[1], -1, 1)
    numbers = numbers_of(here.sides) + (blocks @ pulled).reshape(-1, NUMBERS)
    before, after = (_side(numbers, blocks, side) for side in (0, 1))
    if isinstance(data, ContactTable):
        before = _placed(before, data.bodies, data.normal)
    elif data.on_plate:
        before, after = _placed(_at_rest(before), data.bodies, states.normal), _at_rest(after)
    columns = systematic_columns(data, states, about, line, here)
    sigma = np.concatenate([np.empty(0), *(np.full(len(s.values), s.sigma) for s in calibrated)])
    moved = blocks @ columns.pulled.reshape(*pulled.shape[:3], -1)
    shared = -sigma * moved.reshape(len(data.shots), NUMBERS, -1)
    whole = FreeFlights(
        before=before[0],
        after=after[0],
        before_covariance=before[1],
        after_covariance=after[1],
        before_shared=shared[:, _numbers_of_side(0)],
        after_shared=shared[:, _numbers_of_side(1)],
        bodies=data.bodies,
        covariates=dict(data.covariates),
        measured_s=measured_s,
    )
    encounter, _ = whole.encounter(whole.before, np.zeros(len(data.shots)), 0.0)
    good = np.isfinite(encounter.normal[:, 0]) & (encounter.approach > 0)
    return whole.of_shots(good & np.isfinite(after[0]).all(axis=1))


def _side(numbers: Floats, blocks: Floats, side: int) -> tuple[Floats, Floats]:
    """Return the numbers of one side (S, 18) and their covariance, from all and their blocks."""
    chosen = _numbers_of_side(side)
    shots, count, size = blocks.shape[:3]
    whole = np.zeros((shots, NUMBERS, NUMBERS))
    for k in range(count):
        whole[:, k * size : (k + 1) * size, k * size : (k + 1) * size] = blocks[:, k]
    covariance = whole[:, chosen[:, None], chosen[None, :]]
    unseen = np.diagonal(covariance, axis1=1, axis2=2) <= 0
    rows, columns = np.nonzero(unseen)
    covariance[rows, columns, columns] = UNSEEN**2
    return numbers[:, chosen], covariance


def _numbers_of_side(side: int) -> NDArray[np.intp]:
    """Return which of the 48 numbers are places, velocities and spins of one side, shape (18,)."""
    index = np.arange(NUMBERS).reshape(2, 2, 2, 2, 3)
    return np.concatenate(
        [index[:, 0, side, 0].ravel(), index[:, 0, side, 1].ravel(), index[:, 1, side, 1].ravel()]
    )


def _placed(
    side: tuple[Floats, Floats], bodies: tuple[Body, Body], normal: Floats
) -> tuple[Floats, Floats]:
    """Return a side before contact with the bodies where they touch, without error."""
    numbers, covariance = side[0].copy(), side[1].copy()
    numbers[:, :3], numbers[:, 3:6] = -bodies[0].radius * normal, bodies[1].radius * normal
    covariance[:, :6] = covariance[:, :, :6] = 0.0
    return numbers, covariance


def _at_rest(side: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Return a side of bounces on a plate: it rests, and where it lies nobody has measured."""
    numbers, covariance = side[0].copy(), side[1].copy()
    places = np.arange(6)
    covariance[:, places] = covariance[:, :, places] = 0.0
    covariance[:, places, places] = UNSEEN**2
    numbers[:, OF_PLATE] = 0.0
    covariance[:, OF_PLATE] = covariance[:, :, OF_PLATE] = 0.0
    covariance[:, OF_PLATE, OF_PLATE] = AT_REST**2
    return numbers, covariance


def time_at_distance(gap: Floats, velocity: Floats, reach: float, side: float) -> Floats:
    """Return when |gap + velocity t| is the reach, before (-1) or after (1) the nearest, (S,)."""
    a = np.maximum((velocity**2).sum(axis=1), 1e-12)
    b, c = (gap * velocity).sum(axis=1), (gap**2).sum(axis=1) - reach**2
    square = b**2 - a * c
    root = np.sqrt(np.where(square >= 0, square, np.nan))
    return np.asarray((-b + side * root) / a)


def numbers_of(sides: Flights) -> Floats:
    """Return the 48 numbers of the flights; orientations at contact are of no account here, 0."""
    numbers = np.zeros((len(sides.duration), 2, 2, 2, 2, 3))
    numbers[:, :, 0, :, 0], numbers[:, :, 0, :, 1] = sides.place, sides.velocity
    numbers[:, :, 1, :, 1] = sides.spin
    return numbers.reshape(-1, NUMBERS)


def pseudo_inverse(gram: Floats) -> Floats:
    """Invert information, shape (S, B, N, N); what was not seen is held, with no error."""
    scale = np.sqrt(np.maximum(np.diagonal(gram, axis1=2, axis2=3), 1e-300))
    values, vectors = np.linalg.eigh(gram / scale[..., :, None] / scale[..., None, :])
    seen = values > LEAST_INFORMATION
    share = np.where(seen, 1.0 / np.where(seen, values, 1.0), 0.0)
    whole = (vectors * share[..., None, :]) @ np.swapaxes(vectors, 2, 3)
    known = scale > 1e-140
    held = known[..., :, None] & known[..., None, :]
    return np.asarray(np.where(held, whole / scale[..., :, None] / scale[..., None, :], 0.0))
