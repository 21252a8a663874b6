"""One flight model for a whole film: all bounces from all places at once."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import LEAST_PLACES, Flights, Ints, Observed, Start
from analysis.balls.flight.known import (
    BARREL_SIGMA,
    LEVEL_SIGMA,
    ROLL_SIGMA,
    SHORTENING,
    SHORTENING_SIGMA,
    SMEAR_SIGMA,
    STAY_S,
    Known,
)
from analysis.balls.flight.outlines import outlines

_Chosen = tuple[Ints, NDArray[np.bool_], Floats]
"""Which flight each place belongs to, whether it counts, and by how much its errors are larger."""

LOGARITHMS = [path.FALL, path.DRAG, path.ASLANT]
ROUNDS, AGAIN = 6, 3
"""Of fits with outliers taken out between them: from a first guess, and from a fit before."""
LOOSE, CLOSE = 1e-4, 1e-8
"""Share of the sum of squares by which a step is the last: while the fit settles, and then."""
SOFT = 2.0
"""Residuals beyond so many standard errors count less while the fit settles."""
OUTLIER = 4.5
MARGIN = 0.03
"""Of the time between frames: nothing is taken so near a contact, beside half the exposure."""
GAIN_SHARE = 0.3
"""Of a ball's drift along the line of sight: by how much a bounce changes it."""
LAST_MARGIN = 0.5
"""The same before the bounce that ends the last flight, whose time is not fitted."""
NEAR_RADII = 1.5
"""Heights over the plate at which a ball lies over its shadow."""
LEVEL = np.array([path.TILT, path.ROLL])
"""Their sum is the plate's slope against the horizontal: a camera that is rolled turns both."""
LOW_RADII = 0.5
"""A flight that rises no higher ends a chain of higher ones: it lies over its own shadow."""
LEAST_INFORMATION = 1e-20
"""Of a number that no place that counts depends on."""
MOST_OPEN = 2.0
"""Standard error of a logarithm with which a film says nothing."""
CONTRADICTION = 3.5
"""Standard errors between the scales of diameter and gravity beyond which one of them is wrong."""


class _Problem:
    """The fit's numbers, what they are about, and how places follow from them."""

    def __init__(self, observed: Observed, start: Start, known: Known) -> None:
        ball, view = known.ball, known.view
        self.observed, self.view, self.ball = observed, view, ball
        self.bounces = len(start.times_s)
        self.scale, self.scale_sigma = known.scale()
        drag, drag_spread = ball.drag_per_m()
        row_time, row_sigma = view.row_time()
        count = path.COMMON + path.EACH * self.bounces
        self.prior, self.prior_sigma = np.zeros(count), np.full(count, np.inf)

        def know(index: int, value: float, sigma: float) -> None:
            self.prior[index], self.prior_sigma[index] = value, sigma

        know(path.FALL, math.log(ball.gravity * self.scale), self.scale_sigma)
        know(path.DRAG, math.log(drag / self.scale), drag_spread)
        know(path.ROW_TIME, row_time, row_sigma)
        know(path.PERSPECTIVE, 0.0, view.perspective_sigma())
        know(path.ROLL, 0.0, ROLL_SIGMA)
        know(path.STAY, 0.0, STAY_S * ball.diameter_m / 0.02)
        know(path.SHORTENING, SHORTENING, SHORTENING_SIGMA)
        for index, middle in zip(path.PRINCIPAL, view.principal(), strict=True):
            know(index, middle, 0.0)
        know(path.HALF, 0.5 * (max(view.height, view.width) - 1), 0.0)
        know(path.BIAS, 0.0, SMEAR_SIGMA * view.exposure_s)
        know(path.BARREL, 0.0, BARREL_SIGMA)
        know(path.ASLANT, *view.aslant())
        know(path.OUTLINE, 0.0, known.outline_sigma() if observed.leans is not None else 0.0)
        receding = view.receding_sigma(start.before, start.after)
        know(path.DEPTH, 0.0, receding)
        for index in range(path.COMMON + 2, count, path.EACH):
            know(index, 0.0, GAIN_SHARE * receding)
        self.begin = self._begin(start)
        self.plate_row, self.radius_px = float(self.begin[path.PLATE]), known.radius_px
        self.units = self._units()
        self.free = self.prior_sigma > 0
        self.exposure = view.exposure_s

    def _begin(self, start: Start) -> Floats:
        values = np.where(np.isfinite(self.prior), self.prior, 0.0)
        if start.fall is not None:
            values[path.FALL] = math.log(start.fall)
        values[path.TIME] = start.times_s[0]
        values[path.SPEED] = max(1e-3, start.before[0, 0])
        values[path.PLACE] = start.places[0, 1] - self.prior[path.MIDDLE_COLUMN]
        values[path.ACROSS] = start.before[0, 1]
        values[path.PLATE] = float(np.median(start.places[:, 0]))
        for k in range(self.bounces):
            own = path.COMMON + path.EACH * k
            values[own : own + 2] = max(1e-3, -start.after[k, 0]), start.after[k, 1]
        return values

    def _units(self) -> Floats:
        speed = max(1.0, float(self.begin[path.SPEED]))
        units = np.where(np.isfinite(self.prior_sigma), self.prior_sigma, 1.0)
        units[path.TIME] = 1.0 / speed
        units[path.SPEED] = 0.01 * speed
        units[path.ACROSS] = 0.01 * speed
        units[path.PLACE] = units[path.PLATE] = 1.0
        units[path.TILT] = LEVEL_SIGMA
        units[path.COMMON :: path.EACH] = units[path.COMMON + 1 :: path.EACH] = 0.01 * speed
        return np.where(units > 0, units, 1.0)

    def natural(self, values: Floats) -> Floats:
        """Return the numbers that `path` takes: some of the fit's are logarithms."""
        own = values.copy()
        own[LOGARITHMS] = np.exp(values[LOGARITHMS])
        return own

    def logarithmic(self, natural: Floats) -> Floats:
        """Return the fit's numbers from those that `path` takes."""
        values = natural.copy()
        values[LOGARITHMS] = np.log(natural[LOGARITHMS])
        return values

    def near(self, found: Floats) -> NDArray[np.bool_]:
        """Return which places lie within a few radii of the plate."""
        return np.asarray(np.abs(found[:, 0] - self.plate_row) < NEAR_RADII * self.radius_px)

    def high(self, flights: Flights) -> NDArray[np.bool_]:
        """Return which places belong to flights that leave the shadow at the plate."""
        heights = self.plate_row - flights.observed.places[:, 0]
        arcs = flights.arcs
        tops = [heights[arcs == k].max(initial=0.0) for k in range(flights.bounces + 1)]
        return np.asarray(np.array(tops)[arcs] > LOW_RADII * self.radius_px)

    def times(self, values: Floats) -> Floats:
        """Return when the ball's row was read in each frame."""
        line = self.observed.places[:, 1 if self.view.readout == "columns" else 0]
        return np.asarray(self.observed.times_s + values[path.ROW_TIME] * line)

    def predict(self, values: Floats, arcs: Ints) -> tuple[Floats, Floats]:
        """Return places and contacts."""
        found, contacts = np.zeros((len(arcs), 3)), np.zeros((self.bounces, 6))
        own = self.natural(values)
        path.places(own, self.times(values), arcs, found, contacts)
        found[:, :2] += self.moved(own, found)
        return found, contacts

    def moved(self, own: Floats, found: Floats) -> Floats:
        """Return by how much places come out too far off for their outlines, px, shape (N, 2)."""
        leans = self.observed.leans
        return np.zeros((len(found), 2)) if leans is None else -leans * outlines(own, found)

    def assign(self, values: Floats) -> tuple[Ints, NDArray[np.bool_]]:
        """Return which flight each place belongs to, and which lie clear of all contacts."""
        times = self.times(values)
        arcs = np.zeros(len(times), dtype=np.intp)
        _, contacts = self.predict(values, arcs)
        begins = contacts[:, 0]
        arcs = np.searchsorted(begins, times).astype(np.intp)
        near = 0.5 * self.exposure + MARGIN * self.view.period_s
        clear = np.ones(len(times), dtype=bool)
        stay = max(0.0, float(values[path.STAY]))
        for begin in begins:
            clear &= (times < begin - near) | (times > begin + stay + near)
        # The last flight goes on to a bounce that is not fitted: nothing after it counts.
        last = np.flatnonzero(arcs == self.bounces)
        if len(last):
            lasts = 2.0 * contacts[-1, 3] / math.exp(values[path.FALL])
            again = begins[-1] + stay + lasts
            clear &= times < again - near - LAST_MARGIN * self.view.period_s
        return arcs, clear


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
        problem = _Problem(observed, start, known)
        again = before is not None and before.bounces == problem.bounces
        if before is not None and again:
            problem.begin = problem.logarithmic(before.values)
        fitted = None if start.fall is not None else _settle(problem, again=again)
        if fitted is None or fitted.contradiction:
            problem.prior_sigma[path.FALL] = 10.0
            fitted = replace(_settle(problem, again=fitted is None and again), contradiction=True)
        kept = fitted.longest_chain(problem.high(fitted))
        if len(kept) == fitted.bounces + 1:
            return fitted
        # A flight of few frames ends the chain, or the chain begins after it.
        observed = observed.of(np.isin(fitted.arcs, kept))
        start = start.of(slice(kept[0], kept[-1]) if kept else slice(0, 0))
    return None


def _settle(problem: _Problem, *, again: bool) -> Flights:
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
    problem: _Problem, values: Floats, chosen: _Chosen, loose: NDArray[np.bool_], *, soft: bool
) -> Floats:
    arcs, used, enlarge = chosen
    units = problem.units[loose]
    known = np.isfinite(problem.prior_sigma) & loose

    def residuals(step: Floats) -> Floats:
        moved = values.copy()
        moved[loose] += step * units
        found, _ = problem.predict(moved, arcs)
        errors = problem.observed.sigmas * enlarge
        off = (problem.observed.places - found[:, :2]) / errors
        prior = (moved[known] - problem.prior[known]) / problem.prior_sigma[known]
        level = moved[LEVEL].sum(keepdims=True) / LEVEL_SIGMA if loose[LEVEL].all() else prior[:0]
        every = np.concatenate([off[used].ravel(), prior, level])
        return np.asarray(np.nan_to_num(every, nan=1e6, posinf=1e6, neginf=-1e6))

    loss: Literal["soft_l1", "linear"] = "soft_l1" if soft else "linear"
    slopes: Literal["2-point", "3-point"] = "2-point" if soft else "3-point"
    solved = least_squares(
        residuals,
        np.zeros(len(units)),
        jac=slopes,
        loss=loss,
        f_scale=SOFT,
        max_nfev=60,
        ftol=LOOSE if soft else CLOSE,
    )
    best = values.copy()
    best[loose] += solved.x * units
    return best


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


def _described(problem: _Problem, values: Floats, chosen: _Chosen) -> Flights:
    arcs, used, enlarge = chosen
    observed, free = problem.observed, problem.free
    found, contacts = problem.predict(values, arcs)
    residuals = observed.places - found[:, :2]
    place_slopes, contact_slopes = _slopes(problem, values, arcs)
    own = residuals / (observed.sigmas * enlarge)
    enlarge = enlarge * _enlarged(own, arcs, used, int(free.sum()))
    errors = (observed.sigmas * enlarge)[used]
    design = place_slopes[used][:, :, free] / errors[..., None]
    normal = np.einsum("nap,naq->pq", design, design)
    normal += np.diag(1.0 / problem.prior_sigma[free] ** 2)
    both = np.flatnonzero(np.isin(np.flatnonzero(free), LEVEL))
    normal[np.ix_(both, both)] += 1.0 / LEVEL_SIGMA**2
    covariance = np.zeros((len(values), len(values)))
    # The numbers' units lie many powers of ten apart.
    unit = 1.0 / np.sqrt(np.maximum(np.diag(normal), LEAST_INFORMATION))
    inverse = np.linalg.pinv(normal * np.outer(unit, unit), hermitian=True)
    covariance[np.ix_(free, free)] = inverse * np.outer(unit, unit)
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
        contacts=contacts,
        contact_slopes=contact_slopes,
        observed=replace(observed, places=observed.places - problem.moved(natural, found)),
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


def _slopes(problem: _Problem, values: Floats, arcs: Ints) -> tuple[Floats, Floats]:
    """Return derivatives of places and contacts to the fit's numbers, by central differences."""
    count = len(values)
    place_slopes = np.zeros((len(arcs), 2, count))
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
    return place_slopes, contact_slopes


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
