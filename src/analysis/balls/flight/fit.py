"""One flight model for a whole film: all bounces from all places at once."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.describing import described
from analysis.balls.flight.flights import (
    LARGE_CHI2,
    LEAST_PLACES,
    Flights,
    Ints,
    Observed,
    Start,
)
from analysis.balls.flight.known import Known
from analysis.balls.flight.leaning import leaning_start, leans
from analysis.balls.flight.problem import Problem
from analysis.balls.flight.solving import Chosen, solve

Fit = tuple[Observed, Start, Known, Flights]
"""Places, a first guess of bounces and what is known beforehand, and the flights fitted to them."""

ROUNDS, AGAIN = 6, 3
"""Of fits with outliers taken out between them: from a first guess, and from a fit before."""
OUTLIER = 4.5
ENDLESS = 3e-3
"""Squared side of the picture over the focal length: a lens of eighteen sides."""
MUCH_LEFT, FARTHEST = 2.0, 20.0
"""Errors of places by which they may lie off flights before these are sought afresh, and from which
on a place counts no more than one that lies so far."""
OTHER_FALLS = (0.5, 2.0)
"""Of the stated one, with which flights that fit none are tried: of a radius that is taken for a
diameter, or the other way round."""
OPEN = 10.0
"""Standard error of a logarithm of which nothing is known."""


# Numbers that are tried on the way may run beyond all others: what comes of them does not count.
@np.errstate(over="ignore", invalid="ignore")
def fit_flights(
    observed: Observed,
    start: Start,
    known: Known,
    before: Flights | None = None,
    *,
    other_falls: bool = True,
) -> Flights | None:
    """Fit all flights and bounces of a film.

    A plate is level until several bounces contradict it: where they are says how it lies.
    Unknown: times and speeds of contacts, the plate's row and slope, the fall in px/s^2, drag,
    the vertical's direction, perspective, the time from row to row, how long contacts last.
    Drag, scale and camera have priors (`known`): e's error carries what they leave open. Sizes of a
    compressed film that the flights contradict do not count.

    Parameters
    ----------
    observed
        Places with their stated errors; the scatter about the flights enlarges them.
    start
        Of the bounces.
    before
        A fit of nearly the same places, to go on from.
    other_falls
        Whether flights that end far from the places are sought with other falls too. Of times that
        are only tried hardly any fit, and that costs most of the work.

    Returns
    -------
    The flights; None where no bounce has enough frames on both sides.
    """
    leaning = leaning_start(start)
    if leaning is not None and (before is None or before.leans):
        own = before if before is not None and before.bounces == len(start.times_s) else None
        found = _fit(observed, leaning, known, own, other_falls=other_falls)
        if found is not None and found.bounces > 1 and found.leans and not found.doubt:
            level = _fit(observed, start, known, None, other_falls=other_falls)
            return found if level is None or leans(found, level) else level
    return _fit(observed, start, known, before, other_falls=other_falls)


def _fit(
    observed: Observed, start: Start, known: Known, before: Flights | None, *, other_falls: bool
) -> Flights | None:
    """Fit flights to bounces of a plate that lies as it is said to."""
    flown = 0.0
    while len(start.times_s) and len(observed.places):
        problem = Problem(observed, start, known, flown)
        again = before is not None and before.bounces == problem.bounces
        first = problem.begin
        if before is not None and again:
            problem.begin = problem.logarithmic(before.values)
        fitted = None if start.fall is not None else _settle(problem, again=again)
        if fitted is not None and again and _ran_off(fitted):
            problem.begin = first
            fitted = min(fitted, _settle(problem, again=False), key=rms_in_errors)
        if fitted is not None and not again and problem.begin_receding is not None:
            fitted = _or_receding(problem, fitted, problem.begin_receding)
        # A fit that a wrong fall holds far from the places shows no contradiction.
        lost = fitted is not None and is_astray(fitted)
        if fitted is None or (lost and other_falls) or (fitted.contradiction and not lost):
            fitted = _by_fall(problem, again=again)
        if problem.contradicts_sizes(fitted):
            observed, before = replace(observed, sizes=None), None
            flown = float(fitted.values[path.DEPTH])
            continue
        kept = fitted.longest_chain(problem.high(fitted))
        if len(kept) == fitted.bounces + 1:
            return fitted
        # A flight of few frames ends the chain, or the chain begins after it.
        own = np.isin(fitted.arcs, kept)
        observed = observed.of(own & ~_at_lost_bounces(problem, fitted, kept))
        start = start.of(slice(kept[0], kept[-1]) if kept else slice(0, 0))
    return None


def _or_receding(problem: Problem, fitted: Flights, begin: Floats) -> Flights:
    """Return a fit, or the one that begins with the drift that is shown, if it holds more.

    What else is tried begins there too then.
    """
    first, problem.begin = problem.begin, begin
    other = _settle(problem, again=False)

    def holds(each: Flights) -> tuple[int, float]:
        return len(each.longest_chain(problem.high(each))), -rms_in_errors(each)

    if holds(other) > holds(fitted):
        return other
    problem.begin = first
    return fitted


def _at_lost_bounces(problem: Problem, fitted: Flights, kept: list[int]) -> NDArray[np.bool_]:
    """Return which places lie at the bounces before and after the flights that are kept.

    Once those bounces are no longer fitted, nothing else says that they are none of a flight.
    """
    clear = problem.assign(problem.logarithmic(fitted.values))[1]
    times, bounces = fitted.observed.times_s, fitted.contacts[:, 0]
    ends = (kept[0] - 1, kept[-1]) if kept else ()
    lost = [bounces[k] for k in ends if 0 <= k < len(bounces)]
    nearest = np.abs(times[:, None] - bounces).argmin(axis=1)
    return ~clear & np.isin(bounces[nearest], lost)


def _by_fall(problem: Problem, *, again: bool) -> Flights:
    """Fit flights that bend otherwise than the stated diameter says, without it.

    Where the fitted places do not bend so, the diameter counts again.
    """
    stated, begin = problem.prior_sigma[path.FALL], problem.begin
    problem.prior_sigma[path.FALL] = OPEN
    fitted = _settle(problem, again=again)
    for share in OTHER_FALLS:
        if not is_astray(fitted):
            break
        problem.begin = begin.copy()
        problem.begin[path.FALL] += math.log(share)
        fitted = min(fitted, _settle(problem, again=False), key=rms_in_errors)
    if fitted.contradiction:
        return fitted
    problem.prior_sigma[path.FALL] = stated
    problem.begin = problem.logarithmic(fitted.values)
    return _settle(problem, again=True)


def is_astray(fitted: Flights) -> bool:
    """Return whether a fit has ended far from the places."""
    return fitted.chi2_per_dof > LARGE_CHI2 or not fitted.used.any()


def _ran_off(fitted: Flights) -> bool:
    """Return whether a fit has ended at a lens without end, far from the places.

    What crude places of an earlier pass had it believe holds it there. Where times are wrong places
    lie off as far, with lenses that there are: what then fits better is believed in vain.
    """
    return bool(fitted.values[path.ASLANT] < ENDLESS) and rms_in_errors(fitted) > MUCH_LEFT


def rms_in_errors(fitted: Flights) -> float:
    """Return the root mean square distance of places from flights, in errors; far ones count less.

    Of all places: a wrong fit may leave out more of them.
    """
    apart = np.abs(fitted.residuals / fitted.observed.sigmas)
    return float(np.sqrt((np.minimum(apart, FARTHEST) ** 2).mean()))


def _settle(problem: Problem, *, again: bool) -> Flights:
    return described(problem, *settled(problem, range(ROUNDS - AGAIN if again else 0, ROUNDS)))


def settled(problem: Problem, rounds: range) -> tuple[Floats, Chosen]:
    """Return the numbers of a fit after some of its rounds, and which places they are of."""
    values = problem.begin.copy()
    observed = problem.observed
    enlarge = np.ones((len(observed.frames), 2))
    inlier = np.ones(len(observed.frames), dtype=bool)
    arcs, clear = problem.assign(values)
    used = clear
    for round_ in rounds:
        arcs, clear = problem.assign(values)
        clear = _off_contacts(problem, values, arcs, clear)
        used = clear & inlier
        loose = problem.free.copy()
        if round_ == 0:
            loose[[path.DRAG, path.ROW_TIME, path.PERSPECTIVE, path.TILT]] = False
            loose[path.STAY] &= problem.sees_contacts
            loose[[path.BIAS, path.BARREL, path.SHORTENING, path.ASLANT, path.OUTLINE]] = False
            loose[[path.DEPTH, *range(path.COMMON + 2, len(values), path.EACH)]] = False
        soft = round_ < ROUNDS - 1
        values = solve(problem, values, (arcs, used, enlarge), loose, soft=soft)
        found, _ = problem.predict(values, arcs)
        residuals = observed.places - found[:, :2]
        scaled = residuals / observed.sigmas
        enlarge = _spreads(scaled, used, problem.near(found))
        inlier = np.abs(scaled / enlarge).max(axis=1) < OUTLIER
    return values, (arcs, used, enlarge)


def _off_contacts(
    problem: Problem, values: Floats, arcs: Ints, clear: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return which places are off any contact that may be, whatever it comes out to last.

    A fast camera sees a ball in contact in many frames, in which it does not fly, and a fit that
    takes them for flight finds no contact in them. Of a slow one, and where a flight would lose
    more than half of its places, all that are clear of contacts as they are fitted.
    """
    if not problem.sees_contacts:
        return clear
    off = problem.assign(values, problem.longest_contact_s)[1]
    for arc in range(problem.bounces + 1):
        own = arcs == arc
        if (off & own).sum() < max(LEAST_PLACES, 0.5 * (clear & own).sum()):
            return clear
    return off


def _spreads(scaled: Floats, used: NDArray[np.bool_], near: NDArray[np.bool_]) -> Floats:
    """Return the scatter of residuals in stated errors for each place, shape (N, 2), robustly.

    Near the plate a ball lies over its own shadow: its places there scatter by themselves.
    """
    enlarge = np.ones_like(scaled)
    apart = used & ~near
    if apart.sum() < LEAST_PLACES:
        apart = used
    general = _spread(scaled[apart])
    enlarge[:] = general
    if (used & near).sum() >= LEAST_PLACES:
        enlarge[near] = np.maximum(general, _spread(scaled[used & near]))
    return np.maximum(enlarge, 1e-3)


def _spread(scaled: Floats) -> Floats:
    if len(scaled) < LEAST_PLACES:
        return np.ones(2)
    return np.asarray(1.4826 * np.median(np.abs(scaled), axis=0))
