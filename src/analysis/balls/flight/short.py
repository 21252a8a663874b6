"""Short fits of flights with frames missing: which gaps are worth a whole fit.

A whole fit with wrong times goes astray: other falls are tried, flights are left out one after
another, and each time all others are fitted anew. That takes up to a hundred times as long as a
round or two, which show as well that these times are not the right ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.fit import OPEN, Fit, is_astray, settled
from analysis.balls.flight.flights import Flights, Observed, Start
from analysis.balls.flight.problem import Problem
from analysis.balls.gaps import Gap

FIRST_ROUNDS, NEXT_ROUND = range(2), range(1, 2)
"""Of a fit: from the bounces that were seen, and from flights that are fitted."""
MOST_FARTHER = 2.0
"""Of a fit without a gap, over one that begins otherwise: from farther off nothing begins."""
NEARER = 0.9
"""Of how far places lie without a gap: with one that is worth a whole fit, from bounces."""
FARTHEST = 1e3
"""Errors from which on a place counts no more than one that lies so far."""
OF_BOUNCES = [path.TIME, path.SPEED, path.PLACE, path.ACROSS, path.PLATE]
"""Numbers that bounces as they were seen say; the others are the camera's and the air's."""


@dataclass(frozen=True, slots=True, eq=False)
class Short:
    """A short fit, and what a whole one begins with.

    Attributes
    ----------
    left
        How far all places lie from it.
    observed, start
        Places and bounces with the times that they have with the gap.
    before
        Flights to go on from; None: those of the bounces that were seen.
    """

    left: float
    observed: Observed
    start: Start
    before: Flights | None = None


# A round may end at numbers that run beyond all others: such a fit lies far off.
@np.errstate(over="ignore", invalid="ignore")
def nearest_first(gaps: Iterable[Gap], fit: Fit) -> list[tuple[Gap, Short]]:
    """Return the gaps with which short fits come nearer to the places than without; nearest first.

    They begin with the bounces that were seen and with the flights, where one without a gap comes
    near from there: flights that went astray are no beginning, and long chains are none of bounces
    that are known to a frame. A fit that begins with bounces has rounds to go.
    """
    ways = [(partial(_as_seen, fit), NEARER), (partial(_as_fitted, fit), 1.0)]
    whole = [way(None).left for way, _ in ways]
    near = [own <= MOST_FARTHER * min(whole) for own in whole]
    found: list[tuple[float, Gap, Short]] = []
    for gap in gaps:
        tried = [
            (short.left / own, short)
            for (way, most), own, begins in zip(ways, whole, near, strict=True)
            if begins and (short := way(gap)).left < most * own
        ]
        if tried:
            share, short = min(tried, key=lambda each: each[0])
            found.append((share, gap, short))
    return [(gap, short) for _, gap, short in sorted(found, key=lambda each: each[0])]


def _as_seen(fit: Fit, gap: Gap | None) -> Short:
    """Return a short fit that begins with the bounces that were seen."""
    observed, start, known, flights = fit
    if gap is not None:
        observed, start = _mended(gap, observed, start, known.view.period_s)
    problem = Problem(observed, start, known)
    own = problem.begin.copy()
    if not is_astray(flights):
        problem.begin[: path.COMMON] = problem.logarithmic(flights.values)[: path.COMMON]
        problem.begin[OF_BOUNCES] = own[OF_BOUNCES]
    free = _falls_otherwise(flights)
    values, left = _fitted(problem, FIRST_ROUNDS, free=free)
    fall = float(values[path.FALL]) if free else start.fall
    return Short(left, observed, replace(start, fall=fall))


def _as_fitted(fit: Fit, gap: Gap | None) -> Short:
    """Return a short fit that begins with the flights without a gap.

    The flight in which frames are missing begins faster: it lasts longer by as much. Places that
    these flights leave out are as far as any.
    """
    observed, start, known, flights = fit
    kept = np.isin(observed.frames, flights.observed.frames)
    if not kept.any():
        return Short(math.inf, observed, start)
    first = int(np.argmin(np.abs(start.times_s - flights.contacts[0, 0])))
    first = min(first, len(start.times_s) - flights.bounces)
    observed, start = observed.of(kept), start.of(slice(first, first + flights.bounces))
    values = flights.values.copy()
    if gap is not None:
        shift = gap.count * known.view.period_s
        before = flights.contacts[:, 0] <= _first(gap, observed) - 0.5 * known.view.period_s
        flown = int(before.sum())
        if flown == 0:
            values[path.TIME] += shift
        elif flown < flights.bounces:
            values[path.COMMON + path.EACH * (flown - 1)] += 0.5 * values[path.FALL] * shift
        observed, start = _mended(gap, observed, start, known.view.period_s)
    problem = Problem(observed, start, known)
    problem.begin = problem.logarithmic(values)
    values, left = _fitted(problem, NEXT_ROUND, free=_falls_otherwise(flights))
    left += 2.0 * float(np.sum(~kept)) * math.log1p(FARTHEST**2)
    return Short(left, observed, start, replace(flights, values=values))


def _falls_otherwise(flights: Flights) -> bool:
    """Return whether a ball may fall otherwise than the diameter says."""
    return flights.contradiction or is_astray(flights)


def _mended(gap: Gap, observed: Observed, start: Start, period: float) -> tuple[Observed, Start]:
    """Return places and bounces with the times that they have where frames are missing."""
    late = observed.frames >= gap.frame
    times = observed.times_s + late * gap.count * period
    later = start.times_s > _first(gap, observed) - 0.5 * period
    begun = replace(start, times_s=start.times_s + later * gap.count * period)
    return replace(observed, times_s=times), begun


def _first(gap: Gap, observed: Observed) -> float:
    """Return the time of the first place after a gap, s."""
    return float(observed.times_s[observed.frames >= gap.frame].min(initial=math.inf))


def _fitted(problem: Problem, rounds: range, *, free: bool) -> tuple[Floats, float]:
    """Return the numbers of `path` after some rounds of a fit, and how far all places lie from it.

    The sum of ln(1 + d^2) over distances d in stated errors. Of places on their flights that is
    their sum of squares but for a factor; of errors that are far too small it is the logarithm of
    distances, so that which of two fits is nearer does not hang on them.

    Parameters
    ----------
    free
        Whether the ball falls as places say, whatever its diameter.
    """
    if free:
        problem.prior_sigma[path.FALL] = OPEN
    values = settled(problem, rounds)[0]
    found, _ = problem.predict(values, problem.assign(values)[0])
    off = (problem.observed.places - found[:, :2]) / problem.observed.sigmas
    off = np.minimum(np.abs(np.nan_to_num(off, nan=FARTHEST)), FARTHEST)
    return problem.natural(values), float(np.log1p(off**2).sum())
