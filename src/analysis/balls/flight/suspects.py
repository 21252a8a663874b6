"""Where frames may be missing from a film whose times do not say so."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import LEAST_PLACES, Flights, Observed, Start
from analysis.balls.gaps import MOST_LOST, Gap

LEAST_SHARE, LEAST_SIGMAS = 0.5, 5.0
"""Of a period, and in its errors: a time that flights miss is worth a fit."""
DOUBTFUL, SUSPECT_SIGMAS = 0.3, 3.0
"""Of a period, and in its errors: a time that flights miss in which something may be wrong."""
LEAST_WEIGHT = 1e-6
"""Of what places say of a time, that the fit's other numbers leave: less is rounding."""
LEAST_STEP_PX = 2.0
"""Of a ball off its flight that a time may explain; less is what shadows at the plate do."""
NEAR_STEPS = 0.3
"""Of a step at the first contact: from a place to where the ball was some periods later."""
LOST_FRAMES = 2.0
"""From a bounce that was seen to the contact that was fitted."""
MOST_E = 1.02
"""No ball leaves a plate at rest faster than it came."""
NEARER = 4.0
"""Sum of squared distances from a parabola, over that with a gap, for which this is worth a fit."""
MOST_TRIED = 6
"""Of the surest missing times; of all gaps, six times as many."""
SPEED_STEP = 1e-3
"""Of a period, over which speeds are taken."""


@dataclass(frozen=True, slots=True, eq=False)
class Missed:
    """A time that all frames from one on seem to be later by, in s, with its standard error.

    `along` is the information that it shares with the fit's numbers, 1/s, shape (P,).
    """

    frame: int
    time_s: float
    sigma_s: float
    along: Floats

    @property
    def pull(self) -> float:
        """Return the time in its error."""
        return self.time_s / self.sigma_s


def contact_e(flights: Flights) -> Floats:
    """Return speed away over approach speed of each bounce, shape (B,)."""
    return np.asarray(flights.contacts[:, 3] / flights.contacts[:, 1])


def missed(flights: Flights) -> list[Missed]:
    """Return, for each frame but the first, what all frames from it on seem to be later by."""
    own = flights.used
    errors = (flights.observed.sigmas * flights.sigma_scale)[own]
    speeds = _speeds(flights)[own] / errors
    left = flights.residuals[own] / errors
    slopes = flights.slopes[own] / errors[..., None]
    frames = flights.observed.frames[own]
    # Sums over all frames from each on.
    along = np.cumsum(np.einsum("na,nap->np", speeds, slopes)[::-1], axis=0)[::-1]
    square = np.cumsum((speeds**2).sum(axis=1)[::-1])[::-1]
    score = np.cumsum((speeds * left).sum(axis=1)[::-1])[::-1]
    known = square - np.einsum("np,pq,nq->n", along, flights.covariance, along)
    return [
        Missed(int(frame), float(told / weight), float(1.0 / math.sqrt(weight)), shared)
        for frame, told, weight, whole, shared in zip(
            frames, score, known, square, along, strict=True
        )
        if frame > frames[0] and weight > LEAST_WEIGHT * whole
    ]


def suspects(observed: Observed, start: Start, flights: Flights, period: float) -> Iterator[Gap]:
    """Give gaps that are worth a fit: by the surest missing times, then by places off flights."""
    told = [
        each
        for each in missed(flights)
        if each.time_s > LEAST_SHARE * period and each.pull > LEAST_SIGMAS
    ]
    tried: set[Gap] = set()
    for each in sorted(told, key=lambda one: -one.pull)[:MOST_TRIED]:
        count = round(each.time_s / period)
        for gap in (Gap(each.frame, count + more) for more in (0, 1, -1)):
            if 1 <= gap.count <= MOST_LOST and gap not in tried:
                tried.add(gap)
                yield gap
    others = (
        _of_arcs(observed, start, period),
        _of_places_off(flights, period),
        _at_bounces(observed, start, flights, period),
    )
    for gap in chain.from_iterable(others):
        if gap not in tried and len(tried) < 6 * MOST_TRIED:
            tried.add(gap)
            yield gap


def _of_arcs(observed: Observed, start: Start, period: float) -> Iterator[Gap]:
    """Give gaps by which a parabola goes nearer through the places between two bounces.

    A fit of all flights that no time fits may lie off everywhere.
    """
    arcs = np.searchsorted(start.times_s, observed.times_s)
    for arc in range(len(start.times_s) + 1):
        near = np.abs(observed.times_s[:, None] - start.times_s).min(axis=1) < 1.5 * period
        own = np.flatnonzero((arcs == arc) & ~near)
        if len(own) < 2 * LEAST_PLACES:
            continue
        times, places = observed.times_s[own], observed.places[own]
        late = np.arange(len(own)) >= np.arange(2, len(own) - 1)[:, None]
        counts = np.arange(MOST_LOST + 1)
        squares = _squares(times + counts[:, None, None] * period * late, places)
        count, k = np.unravel_index(int(squares.argmin()), squares.shape)
        # Without a frame lost, all places k are the same parabola.
        if NEARER * squares[count, k] < squares[0, 0]:
            frame = int(observed.frames[own[k + 2]])
            yield from (Gap(frame, int(count) + more) for more in (0, 1))


def _squares(times: Floats, places: Floats) -> Floats:
    """Return the squared distances of places from a parabola, bent along the first axis alone.

    Parameters
    ----------
    times
        Of each place, for each set of times, shape (..., N).
    places
        Shape (N, 2).

    Returns
    -------
    Shape (...).
    """
    gone = (times - times.mean(axis=-1, keepdims=True)) / np.ptp(times, axis=-1)[..., None]
    ways = np.linalg.qr(np.stack([np.ones_like(gone), gone, gone**2], axis=-1))[0]
    apart = places - places.mean(axis=0)
    told = apart.T @ ways  # By constant, slope and bend; shape (..., 2, 3).
    explained = (told**2).sum(axis=(-2, -1)) - told[..., 1, 2] ** 2
    return np.asarray((apart**2).sum() - explained)


def _of_places_off(flights: Flights, period: float) -> Iterator[Gap]:
    """Give gaps beside a contact: a place off the flights that is one of an earlier or later time.

    A ball that is seen beyond the plate before its contact, or too high after it, was filmed later
    than its number says; so was all that follows.
    """
    observed = flights.observed
    times = observed.times_s + flights.row_delay(observed.places)
    off = np.hypot(*flights.residuals.T) > LEAST_STEP_PX
    for index in np.flatnonzero(off & ~flights.used).tolist():
        for arc in {int(flights.arcs[index]), max(0, int(flights.arcs[index]) - 1)}:
            for shift in (*range(1, MOST_LOST), *range(-MOST_LOST, 0)):
                here = flights.at(times[index : index + 1] + shift * period, np.array([arc]))[0, :2]
                near = NEAR_STEPS * float(flights.values[path.SPEED]) * period
                if math.hypot(*(observed.places[index] - here)) > max(near, LEAST_STEP_PX):
                    continue
                # Either it comes after the gap, or those after it do.
                first = index if shift > 0 else index + 1
                if 0 < first < len(times):
                    yield Gap(int(observed.frames[first]), abs(shift))


def _at_bounces(observed: Observed, start: Start, flights: Flights, period: float) -> Iterator[Gap]:
    """Give gaps at bounces where the times do not fit, or where the flights do not tell them."""
    told = missed(flights)
    odd = any(
        abs(each.time_s) > DOUBTFUL * period and abs(each.pull) > SUSPECT_SIGMAS for each in told
    )
    whole = round(flights.early_s / period)
    for time in start.times_s.tolist():
        after = int(np.searchsorted(observed.times_s, time))
        if not 0 < after < len(observed.frames):
            continue
        frame = int(observed.frames[after])
        if odd or _untold(flights, told, time, period):
            yield from (Gap(frame, count) for count in range(1, MOST_LOST + 1))
        # A contact that ends before it has begun.
        if 0 < whole <= MOST_LOST:
            yield Gap(frame, whole)


def _untold(flights: Flights, told: Sequence[Missed], time_s: float, period: float) -> bool:
    """Return whether flights leave open whether frames are missing at a bounce that was seen.

    Of a film of one bounce they say nothing: without them the plate lies higher.
    """
    apart = np.abs(flights.contacts[:, 0] - time_s)
    bounce = int(np.argmin(apart))
    if apart[bounce] > LOST_FRAMES * period or contact_e(flights)[bounce] > MOST_E:
        return True
    after = flights.observed.frames[flights.used & (flights.arcs == bounce + 1)].min()
    own = next((each for each in told if each.frame == after), None)
    return own is not None and max(abs(own.time_s), own.sigma_s) > DOUBTFUL * period


def _speeds(flights: Flights) -> Floats:
    """Return speeds of the ball in the picture at each place, px/s, shape (N, 2)."""
    times = flights.observed.times_s + flights.row_delay(flights.observed.places)
    step = SPEED_STEP * float(np.median(np.diff(flights.observed.times_s)))
    ahead, behind = (flights.at(times + own, flights.arcs)[:, :2] for own in (step, -step))
    return np.asarray((ahead - behind) / (2 * step))
