"""What a fit of flights says, and how surely: errors, scales, and what derivatives leave out."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr, ndtr, ndtri

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import Flights, Ints
from analysis.balls.flight.known import LOOK_SIGMA
from analysis.balls.flight.problem import Problem
from analysis.balls.flight.solving import Chosen, off_beliefs, solve

EARLY = 3.0
"""Standard errors of what is known of contacts by which places alone have one end before it has
begun: what no light at the plate does."""
MOST_SHIFT, MOST_BELOW = 0.01, 20.0
"""Errors by which a time of contact may be shifted without a fit of the others, and how far below
zero its tail is an exponential one to the last digit."""
LEAST_INFORMATION = 1e-20
"""Of a number that no place that counts depends on."""
ENDLESSLY = 1e6
"""px, of a place whose flight, traced back through a drag that stops it at once, has no end."""
MOST_OPEN = 2.0
"""Standard error of a logarithm with which a film says nothing."""
RAN_OFF = 100.0
"""Logarithm of a fall, px/s^2, at which a fit that has run off from its places is held."""
CONTRADICTION = 3.5
"""Standard errors between the scales of diameter and gravity beyond which one of them is wrong."""


def described(problem: Problem, values: Floats, chosen: Chosen) -> Flights:
    """Return fitted flights with their errors.

    Parameters
    ----------
    values
        Of the fit, shape (P,).
    chosen
        With which places, and by how much their errors were found larger.
    """
    arcs, used, enlarge = chosen
    observed, free = problem.observed, problem.free
    slopes = _slopes(problem, values, arcs)
    found, _ = problem.predict(values, arcs)
    used = used & np.isfinite(found).all(axis=1)
    own = _off(observed.places, found) / (observed.sigmas * enlarge)
    enlarge = enlarge * _enlarged(own, arcs, used, int(free.sum()))
    errors = (observed.sigmas * enlarge)[used]
    covariance = _covariance(problem, values, slopes[0][used], errors)
    known_sigmas = problem.prior_sigma.copy()
    early = float(values[path.STAY]) < -EARLY * known_sigmas[path.STAY]
    early_s = -float(values[path.STAY]) if early else 0.0
    lasts, lasts_sigma = _not_negative(
        values[path.STAY], math.sqrt(covariance[path.STAY, path.STAY])
    )
    if lasts - values[path.STAY] > MOST_SHIFT * lasts_sigma:
        others = free & (np.arange(len(values)) != path.STAY)
        values = values.copy()
        values[path.STAY] = lasts
        values = solve(problem, values, (arcs, used, enlarge), others, soft=False)
        slopes = _slopes(problem, values, arcs)
        covariance = _covariance(problem, values, slopes[0][used], errors)
    _hold(covariance, known_sigmas, path.STAY, lasts_sigma)
    _skew(covariance, known_sigmas, path.DRAG)
    found, contacts = problem.predict(values, arcs)
    residuals = _off(observed.places, found)
    place_slopes, contact_slopes, taken_slopes = slopes
    since_s = problem.times(values)[used] - contacts[0, 0]
    pushed = covariance @ np.einsum("np,n->p", place_slopes[used, 0], since_s / errors[:, 0] ** 2)
    rise = _unseen_rise(problem.natural(values), np.sqrt(np.diag(covariance)))
    scaled = residuals[used] / observed.sigmas[used]
    freedom = max(1, 2 * int(used.sum()) - int(free.sum()))
    fall, fall_sigma = values[path.FALL], math.sqrt(covariance[path.FALL, path.FALL])
    told, told_sigma = _without_prior(
        fall, fall_sigma, problem.prior[path.FALL], problem.prior_sigma[path.FALL]
    )
    told = min(max(told, -RAN_OFF), RAN_OFF)
    gravity = problem.ball.gravity
    apart = abs(told - math.log(gravity * problem.scale))
    allowed = CONTRADICTION * math.hypot(told_sigma, problem.scale_sigma)
    natural = problem.natural(values)
    return Flights(
        values=natural,
        covariance=covariance,
        by_rise=rise * pushed,
        known_sigmas=known_sigmas,
        off_beliefs=float((off_beliefs(problem, values, free) ** 2).sum()),
        early_s=early_s,
        drifts=problem.drifts,
        contacts=contacts,
        contact_slopes=contact_slopes,
        observed=replace(observed, places=observed.places - problem.taken(values[None], arcs)[0]),
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
        weighed=problem.ball.density is not None,
    )


def _off(places: Floats, found: Floats) -> Floats:
    """Return places less those of flights; of one that runs beyond all numbers, ENDLESSLY."""
    off = places - found[:, :2]
    return np.asarray(np.where(np.isfinite(off), off, ENDLESSLY))


def _covariance(problem: Problem, values: Floats, slopes: Floats, errors: Floats) -> Floats:
    """Return the covariance of all numbers, shape (P, P); those that are held have none.

    Parameters
    ----------
    values
        The fit's numbers, shape (P,).
    slopes, errors
        Of the places that count, shapes (N, 2, P) and (N, 2).
    """
    free = problem.free
    design = slopes[:, :, free] / errors[..., None]
    normal = np.einsum("nap,naq->pq", design, design)
    normal += np.diag(1.0 / problem.prior_sigma[free] ** 2)
    both = np.flatnonzero(np.isin(np.flatnonzero(free), path.LEVEL))
    normal[np.ix_(both, both)] += 1.0 / problem.start.lean_sigma**2
    for told in (problem.drifts[:, free], problem.beyond(values)[1][:, free]):
        normal += told.T @ told
    covariance = np.zeros((len(free), len(free)))
    # The numbers' units lie many powers of ten apart.
    unit = 1.0 / np.sqrt(np.maximum(np.diag(normal), LEAST_INFORMATION))
    inverse = np.linalg.pinv(normal * np.outer(unit, unit), hermitian=True)
    covariance[np.ix_(free, free)] = inverse * np.outer(unit, unit)
    return covariance


def _not_negative(value: float, sigma: float) -> tuple[float, float]:
    """Return the median of a normal distribution whose negative part is cut off, and its error.

    No contact lasts for less than no time. Contacts of hard balls, which are the commoner ones, are
    the shortest: a median is nearer to them than a mean. Its error is the root mean square about
    it. Far below zero what is left falls off exponentially.
    """
    if sigma == 0.0:
        return value, sigma
    below = -value / sigma
    if below > MOST_BELOW:
        mean = spread = sigma / below
        median = math.log(2.0) * mean
    else:
        ratio = math.exp(-0.5 * below**2 - float(log_ndtr(-below))) / math.sqrt(2.0 * math.pi)
        mean, spread = value + sigma * ratio, sigma * math.sqrt(1.0 + below * ratio - ratio**2)
        median = value + sigma * float(-ndtri(0.5 * ndtr(-below)))
    return median, math.hypot(spread, mean - median)


def _hold(covariance: Floats, known_sigmas: Floats, index: int, sigma: float) -> None:
    """Make one number as sure as that, where it is less sure, and what goes with it."""
    variance = float(covariance[index, index])
    if variance <= sigma**2:
        return
    share = sigma**2 / variance
    covariance -= (1.0 - share) / variance * np.outer(covariance[index], covariance[index])
    more = (1.0 / share - 1.0) / variance
    known_sigmas[index] = (known_sigmas[index] ** -2 + more) ** -0.5


def _skew(covariance: Floats, known_sigmas: Floats, index: int) -> None:
    """Make the error of a logarithm, and what goes with it, as wide as its number's longer side.

    One standard error s up is a factor of exp(s), which is more than s times the number: a ball of
    unknown mass may be far lighter, and slowed far more, than derivatives say.
    """
    variance = float(covariance[index, index])
    if variance <= 0.0:
        return
    longer = math.expm1(math.sqrt(variance)) ** 2 / variance
    covariance += (longer - 1.0) / variance * np.outer(covariance[index], covariance[index])
    known_sigmas[index] *= math.sqrt(longer)


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

    Of places, of contacts, and of what is taken out of places. What runs beyond all numbers depends
    on nothing.
    """
    count = len(values)
    free = np.flatnonzero(problem.free)
    steps = 1e-3 * problem.units[free]
    change = np.zeros((len(free), count))
    change[np.arange(len(free)), free] = steps
    place_slopes = np.zeros((len(arcs), 2, count))
    taken_slopes = np.zeros_like(place_slopes)
    contact_slopes = np.zeros((problem.bounces, 6, count))
    high, low = (problem.predict_each(values + way * change, arcs) for way in (1.0, -1.0))
    taken = problem.taken(values + change, arcs) - problem.taken(values - change, arcs)
    place_slopes[..., free] = np.moveaxis((high[0] - low[0])[..., :2], 0, -1) / (2 * steps)
    contact_slopes[..., free] = np.moveaxis(high[1] - low[1], 0, -1) / (2 * steps)
    taken_slopes[..., free] = np.moveaxis(taken, 0, -1) / (2 * steps)
    for slopes in (place_slopes, contact_slopes, taken_slopes):
        slopes[~np.isfinite(slopes)] = 0.0
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
    if count <= 0.5 * numbers or not size.all():
        # Numbers that follow every place leave no scatter to go by.
        size = np.maximum(size, 1.0)
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
