"""One flight model for a whole film: all bounces from all places at once."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import norm

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import LARGE_CHI2, LEAST_PLACES, Flights, Ints, Observed, Start
from analysis.balls.flight.known import LEVEL_SIGMA, LOOK_SIGMA, Known
from analysis.balls.flight.problem import Problem

_Chosen = tuple[Ints, NDArray[np.bool_], Floats]
"""Which flight each place belongs to, whether it counts, and by how much its errors are larger."""

ROUNDS, AGAIN = 6, 3
"""Of fits with outliers taken out between them: from a first guess, and from a fit before."""
LOOSE, CLOSE = 1e-4, 1e-8
"""Share of the sum of squares by which a step is the last: while the fit settles, and then."""
STEP = 1e-5
"""Of numbers in their units, by which derivatives are taken."""
SOFT = 2.0
"""Residuals beyond so many standard errors count less while the fit settles."""
OUTLIER = 4.5
LEVEL = np.array([path.TILT, path.ROLL])
"""Their sum is the plate's slope against the horizontal: a camera that is rolled turns both."""
ENDLESS = 3e-3
"""Squared side of the picture over the focal length: a lens of eighteen sides."""
MUCH_LEFT, FARTHEST = 2.0, 20.0
"""Errors of places by which they may lie off flights before these are sought afresh, and from which
on a place counts no more than one that lies so far."""
MOST_SHIFT, MOST_BELOW = 0.01, 20.0
"""Errors by which a time of contact may be shifted without a fit of the others, and how far below
zero its tail is an exponential one to the last digit."""
LEAST_INFORMATION = 1e-20
"""Of a number that no place that counts depends on."""
MOST_OPEN = 2.0
"""Standard error of a logarithm with which a film says nothing."""
OPEN = 10.0
"""Standard error of a logarithm of which nothing is known."""
CONTRADICTION = 3.5
"""Standard errors between the scales of diameter and gravity beyond which one of them is wrong."""


def fit_flights(
    observed: Observed, start: Start, known: Known, before: Flights | None = None
) -> Flights | None:
    """Fit all flights and bounces of a film.

    Unknown: times and speeds of contacts, the plate's row and slope, the fall in px/s^2, drag,
    the vertical's direction, perspective, the time from row to row, how long contacts last.
    Drag, scale and camera have priors (`known`): e's error carries what they leave open.

    Parameters
    ----------
    observed
        Places with their stated errors; the scatter about the flights enlarges them.
    start
        Of the bounces.
    before
        A fit of nearly the same places, to go on from.

    Returns
    -------
    The flights; None where no bounce has enough frames on both sides.
    """
    while len(start.times_s):
        problem = Problem(observed, start, known)
        again = before is not None and before.bounces == problem.bounces
        first = problem.begin
        if before is not None and again:
            problem.begin = problem.logarithmic(before.values)
        fitted = None if start.fall is not None else _settle(problem, again=again)
        if fitted is not None and again and _ran_off(fitted):
            problem.begin = first
            fitted = min(fitted, _settle(problem, again=False), key=_left)
        # A fit that a wrong fall holds far from the places shows no contradiction.
        lost = fitted is None or fitted.chi2_per_dof > LARGE_CHI2 or not fitted.used.any()
        if fitted is None or fitted.contradiction or lost:
            fitted = _by_fall(problem, again=again, by_sightings=lost)
        kept = fitted.longest_chain(problem.high(fitted))
        if len(kept) == fitted.bounces + 1:
            return fitted
        # A flight of few frames ends the chain, or the chain begins after it.
        observed = observed.of(np.isin(fitted.arcs, kept))
        start = start.of(slice(kept[0], kept[-1]) if kept else slice(0, 0))
    return None


def _by_fall(problem: Problem, *, again: bool, by_sightings: bool) -> Flights:
    """Fit flights that bend otherwise than the stated diameter says, without it.

    Where sightings alone bend so, and the fitted places do not, the diameter counts again.
    """
    stated = problem.prior_sigma[path.FALL]
    problem.prior_sigma[path.FALL] = OPEN
    fitted = _settle(problem, again=by_sightings and again)
    if not by_sightings or fitted.contradiction:
        return replace(fitted, contradiction=True)
    problem.prior_sigma[path.FALL] = stated
    problem.begin = problem.logarithmic(fitted.values)
    return _settle(problem, again=True)


def _ran_off(fitted: Flights) -> bool:
    """Return whether a fit has ended at a lens without end, far from the places.

    What crude places of an earlier pass had it believe holds it there. Where times are wrong places
    lie off as far, with lenses that there are: what then fits better is believed in vain.
    """
    return bool(fitted.values[path.ASLANT] < ENDLESS) and _left(fitted) > MUCH_LEFT


def _left(fitted: Flights) -> float:
    """Return the root mean square distance of places from flights, in errors; far ones count less.

    Of all places: a wrong fit may leave out more of them.
    """
    apart = np.abs(fitted.residuals / fitted.observed.sigmas)
    return float(np.sqrt((np.minimum(apart, FARTHEST) ** 2).mean()))


def _settle(problem: Problem, *, again: bool) -> Flights:
    values = problem.begin.copy()
    observed = problem.observed
    enlarge = np.ones((len(observed.frames), 2))
    inlier = np.ones(len(observed.frames), dtype=bool)
    arcs, clear = problem.assign(values)
    used = clear
    for round_ in range(ROUNDS - AGAIN if again else 0, ROUNDS):
        arcs, clear = problem.assign(values)
        used = clear & inlier
        loose = problem.free.copy()
        if round_ == 0:
            loose[[path.DRAG, path.ROW_TIME, path.PERSPECTIVE, path.STAY, path.TILT]] = False
            loose[[path.BIAS, path.BARREL, path.SHORTENING, path.ASLANT, path.OUTLINE]] = False
            loose[[path.DEPTH, *range(path.COMMON + 2, len(values), path.EACH)]] = False
        soft = round_ < ROUNDS - 1
        values = _solve(problem, values, (arcs, used, enlarge), loose, soft=soft)
        found, _ = problem.predict(values, arcs)
        residuals = observed.places - found[:, :2]
        scaled = residuals / observed.sigmas
        enlarge = _spreads(scaled, used, problem.near(found))
        inlier = np.abs(scaled / enlarge).max(axis=1) < OUTLIER
    return _described(problem, values, (arcs, used, enlarge))


def _solve(
    problem: Problem, values: Floats, chosen: _Chosen, loose: NDArray[np.bool_], *, soft: bool
) -> Floats:
    arcs, used, enlarge = chosen
    units = problem.units[loose]
    known = np.isfinite(problem.prior_sigma) & loose
    errors = (problem.observed.sigmas * enlarge)[used]
    drifts = problem.drifts if loose[path.DEPTH] else problem.drifts[:0]
    straight = np.vstack(
        [_straight_slopes(problem, known, loose), (drifts * problem.units)[:, loose]]
    )

    def at(step: Floats) -> Floats:
        moved = values.copy()
        moved[loose] += step * units
        return moved

    def seen(moved: Floats) -> Floats:
        return np.asarray((problem.predict(moved, arcs)[0][used, :2] / errors).ravel())

    own = (problem.observed.places[used] / errors).ravel()

    def residuals(step: Floats) -> Floats:
        moved = at(step)
        prior = (moved[known] - problem.prior[known]) / problem.prior_sigma[known]
        level = moved[LEVEL].sum(keepdims=True) / LEVEL_SIGMA if loose[LEVEL].all() else prior[:0]
        apart = drifts @ moved - problem.drifts_target[: len(drifts)]
        every = np.concatenate([own - seen(moved), prior, level, apart])
        return np.asarray(np.nan_to_num(every, nan=1e6, posinf=1e6, neginf=-1e6))

    def slopes(step: Floats) -> Floats:
        here = seen(at(step))
        moved = [seen(at(step + STEP * one)) for one in np.eye(len(units))]
        return np.vstack([np.nan_to_num((here - np.array(moved)) / STEP).T, straight])

    loss: Literal["soft_l1", "linear"] = "soft_l1" if soft else "linear"
    solved = least_squares(
        residuals,
        np.zeros(len(units)),
        jac=slopes,
        loss=loss,
        f_scale=SOFT,
        max_nfev=60,
        ftol=LOOSE if soft else CLOSE,
    )
    return at(solved.x)


def _straight_slopes(
    problem: Problem, known: NDArray[np.bool_], loose: NDArray[np.bool_]
) -> Floats:
    """Return derivatives of what is known beforehand to the numbers that are fitted, in units."""
    each = np.zeros((int(known.sum()), len(loose)))
    each[:, known] = np.diag(problem.units[known] / problem.prior_sigma[known])
    level = np.zeros((1, len(loose)))
    level[0, LEVEL] = problem.units[LEVEL] / LEVEL_SIGMA
    return np.vstack([each, level] if loose[LEVEL].all() else [each])[:, loose]


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


def _described(problem: Problem, values: Floats, chosen: _Chosen) -> Flights:
    arcs, used, enlarge = chosen
    observed, free = problem.observed, problem.free
    slopes = _slopes(problem, values, arcs)
    found, _ = problem.predict(values, arcs)
    own = (observed.places - found[:, :2]) / (observed.sigmas * enlarge)
    enlarge = enlarge * _enlarged(own, arcs, used, int(free.sum()))
    covariance = _covariance(problem, slopes[0][used], (observed.sigmas * enlarge)[used])
    known_sigmas = problem.prior_sigma.copy()
    lasts, lasts_sigma = _not_negative(
        values[path.STAY], math.sqrt(covariance[path.STAY, path.STAY])
    )
    if lasts - values[path.STAY] > MOST_SHIFT * lasts_sigma:
        others = free & (np.arange(len(values)) != path.STAY)
        values = values.copy()
        values[path.STAY] = lasts
        values = _solve(problem, values, (arcs, used, enlarge), others, soft=False)
        slopes = _slopes(problem, values, arcs)
        covariance = _covariance(problem, slopes[0][used], (observed.sigmas * enlarge)[used])
    _hold(covariance, known_sigmas, path.STAY, lasts_sigma)
    found, contacts = problem.predict(values, arcs)
    residuals = observed.places - found[:, :2]
    place_slopes, contact_slopes, taken_slopes = slopes
    errors = (observed.sigmas * enlarge)[used]
    since_s = problem.times(values)[used] - contacts[0, 0]
    pushed = covariance @ np.einsum("np,n->p", place_slopes[used, 0], since_s / errors[:, 0] ** 2)
    rise = _unseen_rise(problem.natural(values), np.sqrt(np.diag(covariance)))
    scaled = residuals[used] / observed.sigmas[used]
    freedom = max(1, 2 * int(used.sum()) - int(free.sum()))
    fall, fall_sigma = values[path.FALL], math.sqrt(covariance[path.FALL, path.FALL])
    told, told_sigma = _without_prior(
        fall, fall_sigma, problem.prior[path.FALL], problem.prior_sigma[path.FALL]
    )
    gravity = problem.ball.gravity
    apart = abs(told - math.log(gravity * problem.scale))
    allowed = CONTRADICTION * math.hypot(told_sigma, problem.scale_sigma)
    natural = problem.natural(values)
    return Flights(
        values=natural,
        covariance=covariance,
        by_rise=rise * pushed,
        known_sigmas=known_sigmas,
        drifts=problem.drifts,
        contacts=contacts,
        contact_slopes=contact_slopes,
        observed=replace(observed, places=observed.places - problem.taken(values, arcs)),
        slopes=place_slopes,
        taken_slopes=taken_slopes,
        arcs=arcs,
        used=used,
        residuals=residuals,
        sigma_scale=enlarge,
        chi2_per_dof=float((scaled**2).sum() / freedom),
        scale_px_per_m=natural[path.FALL] / gravity,
        scale_of_fall=(math.exp(told) / gravity, told_sigma),
        scale_of_diameter=(problem.scale, problem.scale_sigma),
        contradiction=apart > allowed,
        readout=problem.view.readout,
    )


def _covariance(problem: Problem, slopes: Floats, errors: Floats) -> Floats:
    """Return the covariance of all numbers, shape (P, P); those that are held have none.

    Parameters
    ----------
    slopes, errors
        Of the places that count, shapes (N, 2, P) and (N, 2).
    """
    free = problem.free
    design = slopes[:, :, free] / errors[..., None]
    normal = np.einsum("nap,naq->pq", design, design)
    normal += np.diag(1.0 / problem.prior_sigma[free] ** 2)
    both = np.flatnonzero(np.isin(np.flatnonzero(free), LEVEL))
    normal[np.ix_(both, both)] += 1.0 / LEVEL_SIGMA**2
    drifts = problem.drifts[:, free]
    normal += drifts.T @ drifts
    covariance = np.zeros((len(free), len(free)))
    # The numbers' units lie many powers of ten apart.
    unit = 1.0 / np.sqrt(np.maximum(np.diag(normal), LEAST_INFORMATION))
    inverse = np.linalg.pinv(normal * np.outer(unit, unit), hermitian=True)
    covariance[np.ix_(free, free)] = inverse * np.outer(unit, unit)
    return covariance


def _not_negative(value: float, sigma: float) -> tuple[float, float]:
    """Return mean and standard deviation of a normal distribution whose negative part is cut off.

    No contact lasts for less than no time. Far below zero what is left falls off exponentially.
    """
    if sigma == 0.0:
        return value, sigma
    below = -value / sigma
    ratio = math.exp(float(norm.logpdf(below) - norm.logsf(below)))
    share = max(1.0 + below * ratio - ratio**2, below**-2 if below > MOST_BELOW else 0.0)
    return value + sigma * ratio, sigma * math.sqrt(share)


def _hold(covariance: Floats, known_sigmas: Floats, index: int, sigma: float) -> None:
    """Make one number as sure as that, where it is less sure, and what goes with it."""
    variance = float(covariance[index, index])
    if variance <= sigma**2:
        return
    share = sigma**2 / variance
    covariance -= (1.0 - share) / variance * np.outer(covariance[index], covariance[index])
    more = (1.0 / share - 1.0) / variance
    known_sigmas[index] = (known_sigmas[index] ** -2 + more) ** -0.5


def _unseen_rise(values: Floats, sigmas: Floats) -> float:
    """Return the standard error of the speed, px/s, at which what drifts away seems to rise.

    It is the drift times `path.rise`, perspective times the squared focal length, px^2. Where each
    of them may be nothing and is hardly known, derivatives at what was fitted leave most of it out:
    here are the mean squares of drift and perspective, and of what the focal length makes of them.
    """
    drift, by_drift = values[path.DEPTH], sigmas[path.DEPTH]
    side = 2.0 * values[path.HALF]
    per_perspective = side**2 / max(values[path.ASLANT], path.LEAST_ASLANT)
    rise, by_look = path.rise(values), sigmas[path.PERSPECTIVE] * per_perspective
    spread = sigmas[path.ASLANT]
    square = rise**2 * (1.0 + spread**2) + by_look**2 * math.exp(spread**2)
    # A camera stands with its line of sight near the plane of the flight, whatever its lens.
    square = min(square, rise**2 + LOOK_SIGMA**2 * per_perspective * math.exp(0.5 * spread**2))
    in_slopes = rise**2 * (1.0 + spread**2) + by_look**2
    whole = (drift**2 + by_drift**2) * square
    return math.sqrt(max(0.0, whole - drift**2 * in_slopes - by_drift**2 * rise**2))


def _slopes(problem: Problem, values: Floats, arcs: Ints) -> tuple[Floats, Floats, Floats]:
    """Return derivatives to the fit's numbers, by central differences.

    Of places, of contacts, and of what is taken out of places.
    """
    count = len(values)
    place_slopes = np.zeros((len(arcs), 2, count))
    taken_slopes = np.zeros_like(place_slopes)
    contact_slopes = np.zeros((problem.bounces, 6, count))
    for p in np.flatnonzero(problem.free).tolist():
        step = 1e-3 * problem.units[p]
        above, below = values.copy(), values.copy()
        above[p] += step
        below[p] -= step
        high, high_contacts = problem.predict(above, arcs)
        low, low_contacts = problem.predict(below, arcs)
        place_slopes[..., p] = (high - low)[:, :2] / (2 * step)
        contact_slopes[..., p] = (high_contacts - low_contacts) / (2 * step)
        taken = problem.taken(above, arcs) - problem.taken(below, arcs)
        taken_slopes[..., p] = taken / (2 * step)
    return place_slopes, contact_slopes, taken_slopes


def _enlarged(scaled: Floats, arcs: Ints, used: NDArray[np.bool_], numbers: int) -> Floats:
    """Return by how much errors are larger than stated: scatter, and its memory along a flight.

    Neighbouring frames err alike where shading or a codec move a rim: with a correlation r from
    frame to frame a mean is worse by (1 + r) / (1 - r).
    """
    chosen = scaled[used]
    count = len(chosen)
    freedom = max(1.0, count - 0.5 * numbers)
    size = np.sqrt((chosen**2).sum(axis=0) / freedom)
    same = arcs[used][1:] == arcs[used][:-1]
    alike = np.zeros(2)
    if same.sum() > 8:
        pairs = (chosen[1:] * chosen[:-1])[same].mean(axis=0)
        alike = np.clip(pairs / np.maximum((chosen**2).mean(axis=0), 1e-12), 0.0, 0.8)
    return np.asarray(size * np.sqrt((1 + alike) / (1 - alike)))


def _without_prior(
    value: float, sigma: float, prior: float, prior_sigma: float
) -> tuple[float, float]:
    """Return what the film alone says where its fit held a prior too."""
    weight = 1.0 / sigma**2 - 1.0 / prior_sigma**2
    if weight <= max(1e-6 / sigma**2, 1.0 / MOST_OPEN**2):
        return prior, math.inf
    return (value / sigma**2 - prior / prior_sigma**2) / weight, 1.0 / math.sqrt(weight)
