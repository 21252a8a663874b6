"""Frames that are missing from a film whose times do not say so.

Where n frames are missing, all that follows was filmed n periods later than its number says: a
ball jumps by n + 1 of its steps. One time that is added to all frames from a place on is one more
number of the fit. A whole number of periods that explains what flights do not is believed where
the places hold it to a small part of a period.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.fit import fit_flights, rms_in_errors
from analysis.balls.flight.flights import LEAST_PLACES, Flights, Observed, Start
from analysis.balls.flight.known import Known
from analysis.balls.gaps import MOST_LOST, Gap, period_of

LEAST_SHARE, LEAST_SIGMAS = 0.5, 5.0
"""Of a period, and in its errors: a time that flights miss is worth a fit."""
DOUBTFUL, SUSPECT_SIGMAS = 0.3, 3.0
"""Of a period, and in its errors: a time that flights miss in which something may be wrong."""
LEAST_WEIGHT = 1e-6
"""Of what places say of a time, that the fit's other numbers leave: less is rounding."""
WHOLE, SHARP = 0.2, 0.1
"""Of a period: by how much what flights miss may differ from whole periods, and its error."""
LEAST_STEP_PX = 2.0
"""Of a ball off its flight that a time may explain; less is what shadows at the plate do."""
NEAR_STEPS = 0.3
"""Of a step at the first contact: from a place to where the ball was some periods later."""
LEAST_GAIN = 60.0
"""Of the sum of squared distances in errors: by how much less it is at least with mended times."""
DOUBT_GAIN = 25.0
"""The same with times that are not sure: from here on they may be the right ones."""
LOST_FRAMES = 2.0
"""From a bounce that was seen to the contact that was fitted."""
MOST_SCATTER_PX = 1.0
"""Of rows about flights: more is no error of places, but of the times."""
MOST_E = 1.02
"""No ball leaves a plate at rest faster than it came."""
NEARER = 4.0
"""Sum of squared distances from a parabola, over that with a gap, for which this is worth a fit."""
MOST_TRIED = 6
WORSE, WORSE_WITH_MORE = 2.0, 3.0
"""Mean square of the residuals, over that without a gap, with which nothing is mended; and where
the flights then have more bounces, which leave more."""
LEAST_KEPT = 0.5
"""Of the places to which flights were fitted: a fit with mended times that goes through fewer is
one of other bounces."""
MOST_COST = 0.02
"""Of what mended times gain at places that flights left out: by how much the rest may lie worse."""
EXPLAINED = 1.2
"""Root mean square distance of all places from flights, in their stated errors, that is noise."""
NEAR_BY, MOST_CHANCE = 3.0, 0.02
"""Errors within which mended times bring a place to its flight, and the chance, over how far they
lay off, that all do that others left out."""
FARTHEST = 12.0
"""Errors from which on a place counts no more than one that lies so far."""
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


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """What flights say of missing frames.

    Attributes
    ----------
    gap
        The surest place; None where no whole number of frames surely explains what flights do not.
    unsure_e
        By how much e of each bounce changes by gaps that explain much and are not sure, shape (B,).
    """

    gap: Gap | None
    unsure_e: Floats


def find_gap(observed: Observed, start: Start, known: Known, flights: Flights) -> Found:
    """Return the surest place at which frames are missing, and what unsure ones would change.

    Parameters
    ----------
    observed, start, known
        As the flights were fitted.
    """
    period = known.view.period_s
    most: tuple[int, float] = flights.bounces, LEAST_GAIN
    best: Gap | None = None
    unsure = np.zeros(flights.bounces)
    if flights.observed.sizes is None:
        observed = replace(observed, sizes=None)
    # Of a diameter that contradicts gravity the right times fit with another fall alone.
    other = flights.contradiction
    for gap in _worth(observed, start, flights, period):
        late = observed.frames >= gap.frame
        times = observed.times_s + late * gap.count * period
        later = start.times_s > observed.times_s[late].min() - 0.5 * period
        begun = replace(start, times_s=start.times_s + later * gap.count * period)
        fitted = fit_flights(replace(observed, times_s=times), begun, known, other_falls=other)
        if fitted is None or fitted.bounces < flights.bounces or _elsewhere(flights, fitted):
            continue
        if (fitted.observed.sizes is None) != (observed.sizes is None):
            continue  # Without sizes any times fit better.
        gain = _gain(flights, fitted)
        worse = fitted.chi2_per_dof / flights.chi2_per_dof
        if fitted.bounces > flights.bounces:
            # What was a bounce to those who sought flights is one again.
            near = float(np.std(fitted.residuals[fitted.used, 0])) < MOST_SCATTER_PX
            explains = near and (gain > LEAST_GAIN or worse < WORSE_WITH_MORE)
        else:
            explains = worse < WORSE
            if explains and gain > DOUBT_GAIN and _holds(fitted, gap, period, math.inf):
                unsure = np.maximum(unsure, np.abs(_e(fitted) - _e(flights)))
        better = explains and (fitted.bounces, gain) > most
        if better and _holds(fitted, gap, period):
            most, best = (fitted.bounces, gain), _placed(fitted, gap, period)
            if rms_in_errors(fitted) < EXPLAINED:
                break
    return Found(best, unsure)


def _e(flights: Flights) -> Floats:
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


def _worth(observed: Observed, start: Start, flights: Flights, period: float) -> Iterator[Gap]:
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


def unsure_e(flights: Flights) -> Floats:
    """Return by how much e of each bounce changes where a time is missing that no frames explain.

    Shape (B,).
    """
    period = period_of(flights.observed.times_s)
    most = np.zeros(flights.bounces)
    for each in missed(flights):
        sharp = each.sigma_s < SHARP * period and abs(each.pull) > LEAST_SIGMAS
        if sharp and abs(each.time_s) > LEAST_SHARE * period:
            moved = flights.covariance @ each.along * each.time_s
            change = [abs(float(flights.slopes_of_e(b) @ moved)) for b in range(flights.bounces)]
            most = np.maximum(most, change)
    return most


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
    if apart[bounce] > LOST_FRAMES * period or _e(flights)[bounce] > MOST_E:
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


def _elsewhere(flights: Flights, fitted: Flights) -> bool:
    """Return whether a fit left out most places of the flights, of which it then says nothing."""
    kept = np.isin(flights.observed.frames, fitted.observed.frames)
    return float(kept.mean()) < LEAST_KEPT


def _gain(flights: Flights, fitted: Flights) -> float:
    """Return by how much nearer places lie to fitted flights than to others, squared, in errors.

    Of places that one of both goes through; far ones count no more than FARTHEST. What it gains at
    places that the others leave out does not count where it costs those that both go through,
    or where any time may be right for so few: over a shadow single places lie off by themselves.

    The errors are those of the fitted flights, and the sum is formed twice, the larger counts: once
    with each place's own error, and once with the median of all. Near the plate, where a ball lies
    over its shadow, errors are wide, and with them the places there would count for nothing.
    """
    here, there = flights.observed.frames, fitted.observed.frames
    _, own, theirs = np.intersect1d(here, there, return_indices=True)
    each = (fitted.observed.sigmas * fitted.sigma_scale)[theirs]
    left, better = np.abs(flights.residuals[own]), np.abs(fitted.residuals[theirs])
    before, after = flights.used[own], fitted.used[theirs]
    most = 0.0
    for errors in (each, np.median(each, axis=0)):
        far, near = left / errors, better / errors
        gain = np.minimum(far, FARTHEST) ** 2 - np.minimum(near, FARTHEST) ** 2
        shared = float(gain[before & after].sum())
        won, lost = (float(gain[own].sum()) for own in (after & ~before, before & ~after))
        chance = np.minimum(1.0, NEAR_BY / far[after & ~before].max(axis=1)).prod()
        if shared >= -MOST_COST * (won + lost):
            most = max(most, shared + lost + (won if chance < MOST_CHANCE else 0.0))
    return most


def contradicted(fitted: Flights, gaps: Iterable[Gap]) -> bool:
    """Return whether flights with missing frames put in say that these are not missing."""
    period = period_of(fitted.observed.times_s)
    left = (_left(fitted, gap) for gap in gaps)
    return any(
        each is not None and each.time_s < -LEAST_SHARE * period and each.pull < -LEAST_SIGMAS
        for each in left
    )


def _placed(fitted: Flights, gap: Gap, period: float) -> Gap:
    """Return a gap before the frame that leaves places nearest to the flights."""
    observed = fitted.observed
    times = observed.times_s + fitted.row_delay(observed.places)
    late = observed.frames >= gap.frame
    errors = observed.sigmas * fitted.sigma_scale
    costs = []
    for own in (False, True):
        shift = (own * 1.0 - late) * gap.count * period
        away = observed.places - fitted.at(times + shift, fitted.arcs)[:, :2]
        away = np.where((late == own)[:, None], fitted.residuals, away)
        costs.append((np.minimum(np.abs(away / errors), FARTHEST) ** 2).sum(axis=1))
    early, after = costs
    before = np.concatenate([[0.0], np.cumsum(early)])
    total = before + np.concatenate([np.cumsum(after[::-1])[::-1], [0.0]])
    return replace(gap, frame=int(observed.frames[1 + int(np.argmin(total[1:-1]))]))


def _holds(fitted: Flights, gap: Gap, period: float, sharp: float = SHARP) -> bool:
    """Return whether flights with mended times hold just these: to a small part of a period."""
    left = _left(fitted, gap)
    if left is None:
        return False
    return abs(left.time_s) < WHOLE * period and left.sigma_s < sharp * period


def _left(fitted: Flights, gap: Gap) -> Missed | None:
    """Return the time that is missing at a place still; None where flights do not tell it."""
    own = fitted.observed.frames[fitted.used]
    first = own[own >= gap.frame].min(initial=own.max())
    return next((each for each in missed(fitted) if each.frame == first), None)
