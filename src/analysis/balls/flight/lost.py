"""Frames that are missing from a film whose times do not say so.

Where n frames are missing, all that follows was filmed n periods later than its number says: a
ball jumps by n + 1 of its steps. One time that is added to all frames from a place on is one more
number of the fit. A whole number of periods that explains what flights do not is believed where
the places hold it to a small part of a period.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight.fit import fit_flights, rms_in_errors
from analysis.balls.flight.flights import Flights, Observed, Start
from analysis.balls.flight.known import Known
from analysis.balls.flight.short import nearest_first
from analysis.balls.flight.suspects import (
    LEAST_SHARE,
    LEAST_SIGMAS,
    Missed,
    contact_e,
    missed,
    suspects,
)
from analysis.balls.gaps import Gap, period_of

WHOLE, SHARP = 0.2, 0.1
"""Of a period: by how much what flights miss may differ from whole periods, and its error."""
MOST_WHOLE = 6
"""Whole fits, of the gaps with which short ones come nearest to the places."""
LEAST_GAIN = 60.0
"""Of the sum of squared distances in errors: by how much less it is at least with mended times."""
DOUBT_GAIN = 25.0
"""The same with times that are not sure: from here on they may be the right ones."""
MOST_SCATTER_PX = 1.0
"""Of rows about flights: more is no error of places, but of the times."""
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
    likely = nearest_first(
        suspects(observed, start, flights, period), (observed, start, known, flights)
    )
    for gap, short in likely[:MOST_WHOLE]:
        fitted = fit_flights(short.observed, short.start, known, short.before, other_falls=other)
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
                unsure = np.maximum(unsure, np.abs(contact_e(fitted) - contact_e(flights)))
        better = explains and (fitted.bounces, gain) > most
        if better and _holds(fitted, gap, period):
            most, best = (fitted.bounces, gain), _placed(fitted, gap, period)
            if rms_in_errors(fitted) < EXPLAINED:
                break
    return Found(best, unsure)


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
