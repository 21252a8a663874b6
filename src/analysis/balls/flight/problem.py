"""The numbers of a fit of flights, what is known of them, and how places follow from them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.beginning import first_numbers, off_contacts, receding
from analysis.balls.flight.drift import Drift, drift
from analysis.balls.flight.flights import Flights, Ints, Observed, Start
from analysis.balls.flight.kinds import contact_time
from analysis.balls.flight.known import (
    BARREL_SIGMA,
    LEVEL_SIGMA,
    LOOK_SIGMA,
    ROLL_SIGMA,
    SHORTENING,
    SHORTENING_SIGMA,
    SMEAR_SIGMA,
    Known,
)


def outlines(values: Floats, seen: Floats) -> Floats:
    """Return relative changes of the half axes along rows and columns, shape (..., N, 2).

    How large and how round a ball is seen on its way: it drifts, and away from the middle of the
    picture the outline of a sphere is an ellipse, longer towards the border by half of the squared
    tangent of the angle to the line of sight. Changes are those to the outline with which its
    places were fitted, whose radius has an error too.

    Parameters
    ----------
    values
        Of `path`, shape (..., K).
    seen
        Row, column, and distance in its value at the first contact, shape (..., N, 3).
    """
    values = values[..., None, :]
    tangents = (seen[..., :2] - values[..., path.PRINCIPAL]) / (2.0 * values[..., [path.HALF]])
    aslant = 0.5 * values[..., [path.ASLANT]] * tangents**2
    return np.asarray(1.0 / seen[..., 2:] - 1.0 + values[..., [path.OUTLINE]] + aslant)


LOGARITHMS = [path.FALL, path.DRAG, path.ASLANT]
THROWN_SHARE = 0.1
"""Of a thrown ball's speed: how much of it may be along the line of sight."""
MARGIN = 0.03
"""Of the time between frames: nothing is taken so near a contact, beside half the exposure."""
LAST_MARGIN = 0.5
"""The same before the bounce that ends the last flight, whose time is not fitted."""
GAIN_SHARE, GAIN_SIGMA = 0.2, 0.12
"""Of a ball's drift along the line of sight: friction takes between nothing and 2/5 of it at a
bounce of a ball without spin; the middle, and its standard error."""
SIZES_OFF = 4.0
"""Errors by which flights contradict what sizes say of drifts and perspective: those of a film that
a codec has been at are then a shadow's beside the ball, or a smear's."""
MOST_SIGMAS = 2.0
"""Of a camera's tilt and of a ball's speeds along the line of sight, beyond which they are none."""
LASTS_SIGMAS = 2.0
"""Of what is known of contacts' durations: so long one may last before and after a first guess."""
FURTHEST_UNITS = 1e4
"""From where a fit begins to what is far beyond belief: a hundred times a speed."""
BARE_SHARE = 0.02
"""Of what a ball's drift may be, where its own light is not known yet: what that does to places
bends flights as drifts do."""
NEAR_RADII = 1.5
"""Heights over the plate at which a ball lies over its shadow."""
LOW_RADII = 0.5
"""A flight that rises no higher ends a chain of higher ones: it lies over its own shadow."""


def _beside(start: Start) -> tuple[Floats, Floats]:
    """Return speeds before and after each bounce as those of a ball that is dropped on a plate.

    What tells how a ball may drift along the line of sight is its speed across the picture; of one
    that is thrown at a wall that is a part of all its speed, and what friction and spin may change
    is its speed along the wall.
    """
    if not start.off_a_wall:
        return start.before, start.after
    before, after = (
        np.column_stack([np.hypot(*speeds.T), THROWN_SHARE * np.hypot(*speeds.T)])
        for speeds in (start.before, start.after)
    )
    return before, after


def _below(observed: Observed, start: Start) -> Floats:
    """Return where the plate is at the time of each place, shape (N, 2), px: between bounces.

    Those of a ball that comes nearer sink in the picture of a camera that looks down.
    """
    return np.column_stack(
        [np.interp(observed.times_s, start.times_s, places) for places in start.places.T]
    )


class Problem:
    """The fit's numbers, what they are about, and how places follow from them."""

    def __init__(self, observed: Observed, start: Start, known: Known, flown: float = 0.0) -> None:
        """Set up the fit.

        Parameters
        ----------
        flown
            Drift, in distances of the camera a second, of flights that were fitted with sizes which
            they contradict: one as large is believed, though sizes no longer count. 0: none were.
        """
        ball, view = known.ball, known.view
        self.observed, self.view, self.ball, self.start = observed, view, ball, start
        self.bounces, beside = len(start.times_s), _beside(start)
        self.scale, self.scale_sigma = known.scale()
        per_focal = view.per_focal(self.scale)
        self._know_beforehand(known, per_focal)
        drifts = view.receding_sigma(*beside, per_focal)
        if observed.bare:
            drifts *= BARE_SHARE
        begin = start
        if self.sees_contacts:
            fall = math.exp(self.prior[path.FALL]) if start.fall is None else start.fall
            begin = off_contacts(observed, start, fall, self.longest_contact_s)
        self.begin = first_numbers(begin, self.prior)
        self.plate, self.radius_px = _below(observed, start), known.radius_px
        self.normal = np.array([-math.cos(start.lean), math.sin(start.lean)])
        by_sizes = drift(observed, start.times_s, ~self.near(observed.places), known)
        # Directions are by chance: a ball may come nearer far faster than it crosses the picture,
        # rarely, but no more so the faster it does. What is shown beyond its error is believed.
        rate, off = (flown, 0.0) if flown else by_sizes.one_rate()
        shown = abs(rate) > max(drifts, MOST_SIGMAS * off)
        self.likeliest, spread = aslant = view.aslant(self.scale)
        self.begin_receding = receding(self.begin, start, rate, aslant) if shown else None
        drifts = math.sqrt(drifts**2 + max(0.0, rate**2 - off**2))
        self._know(path.DEPTH, 0.0, drifts)
        by_friction_alone = GAIN_SIGMA * by_sizes.of_all_flights(drifts)
        gains = np.hypot(by_friction_alone, view.receding_by_spin(*beside, per_focal))
        by_friction = self._of_drifts(by_sizes, gains)
        # As they would be at the likeliest focal length; errors hold that it is not known.
        tilt, speed = np.zeros((2, len(self.prior)))
        tilt[path.PERSPECTIVE], speed[path.DEPTH] = 1.0 / (LOOK_SIGMA * per_focal), 1.0 / drifts
        # Friction takes a share of a drift, which may itself be as large as is believed.
        by_share = by_friction / MOST_SIGMAS
        self.far = np.vstack([tilt, speed, by_share]) * math.exp(0.25 * spread**2)
        self.units = self._units()
        self.units[path.COMMON + 2 :: path.EACH] = gains
        # What no place that counts depends on would run away.
        unknown = np.isinf(self.prior_sigma)
        self.prior[unknown] = self.begin[unknown]
        self.prior_sigma[unknown] = FURTHEST_UNITS * self.units[unknown]
        self.free = self.prior_sigma > 0
        self.exposure = view.exposure_s

    def _know(self, index: int, value: float, sigma: float) -> None:
        self.prior[index], self.prior_sigma[index] = value, sigma

    def _know_beforehand(self, known: Known, per_focal: float) -> None:
        """Set what is known of the numbers, but for how the ball drifts."""
        ball, view = known.ball, known.view
        drag, drag_spread = known.drag or ball.drag_per_m()
        row_time, row_sigma = view.row_time()
        count = path.COMMON + path.EACH * self.bounces
        self.prior, self.prior_sigma = np.zeros(count), np.full(count, np.inf)
        self._know(path.FALL, math.log(ball.gravity * self.scale), self.scale_sigma)
        self._know(path.DRAG, math.log(drag / self.scale), drag_spread)
        self._know(path.ROW_TIME, row_time, row_sigma)
        self._know(path.PERSPECTIVE, 0.0, LOOK_SIGMA * per_focal)
        self._know(path.ROLL, 0.0, ROLL_SIGMA)
        self._know(path.STAY, *contact_time(ball))
        self._know(path.SHORTENING, SHORTENING, SHORTENING_SIGMA)
        for index, middle in zip(path.PRINCIPAL, view.principal(), strict=True):
            self._know(index, middle, 0.0)
        self._know(path.HALF, 0.5 * (max(view.height, view.width) - 1), 0.0)
        self._know(path.BIAS, 0.0, SMEAR_SIGMA * view.exposure_s)
        self._know(path.BARREL, 0.0, BARREL_SIGMA)
        self._know(path.ASLANT, *view.aslant(self.scale))
        self._know(
            path.OUTLINE, 0.0, known.outline_sigma() if self.observed.leans is not None else 0.0
        )

    @property
    def sees_contacts(self) -> bool:
        """Return whether contacts are unsure by more than the time between frames.

        A fit may then take frames of the ball in contact for frames of its flight.
        """
        return self.view.period_s < LASTS_SIGMAS * float(self.prior_sigma[path.STAY])

    @property
    def longest_contact_s(self) -> float:
        """Return how long a contact may last, by what is known of it."""
        return float(self.prior[path.STAY] + LASTS_SIGMAS * self.prior_sigma[path.STAY])

    def beyond(self, values: Floats) -> tuple[Floats, Floats]:
        """Return by how much tilt and speeds along the line of sight are beyond belief, in errors.

        Perspective is the tilt over the focal length, and a drift is a speed over it: an endless
        lens would let both be of any size, and what drifts away would rise as fast as balls do.

        Returns
        -------
        What is beyond MOST_SIGMAS, shape (B + 2,), and its derivatives, shape (B + 2, P).
        """
        nearer = math.exp(0.5 * (float(values[path.ASLANT]) - self.likeliest))
        slopes = self.far / nearer
        each = slopes @ values
        over = np.sign(each) * np.maximum(0.0, np.abs(each) - MOST_SIGMAS)
        slopes[:, path.ASLANT] -= 0.5 * each
        return over, np.where(over[:, None] != 0.0, slopes, 0.0)

    def contradicts_sizes(self, flights: Flights) -> bool:
        """Return whether flights say that the sizes of a compressed film are none of its ball's."""
        # The rest of the equations are those of friction, one for each bounce.
        said = slice(0, len(self.drifts_target) - self.bounces)
        off = self.drifts[said] @ self.logarithmic(flights.values) - self.drifts_target[said]
        return self.view.compressed and bool(np.abs(off).max(initial=0.0) > SIZES_OFF)

    def _of_drifts(self, by_sizes: Drift, gains: Floats) -> Floats:
        """Set what sizes and friction say of drifts; return what friction does, shape (B, P)."""
        told = self._told(len(self.prior))
        by_friction = (told[1:-1] - (1.0 - GAIN_SHARE) * told[:-2]) / gains[:, None]
        self.drifts = np.vstack([by_sizes.weights @ told, by_friction])
        self.drifts_target = np.concatenate([by_sizes.target, np.zeros(self.bounces)])
        return np.asarray(by_friction)

    def _told(self, count: int) -> Floats:
        """Return derivatives of the flights' drifts and of the perspective, shape (B + 2, P)."""
        told = np.zeros((self.bounces + 2, count))
        told[:-1, path.DEPTH] = 1.0
        for k in range(self.bounces):
            told[k + 1 : -1, path.COMMON + path.EACH * k + 2] = 1.0
        told[-1, path.PERSPECTIVE] = 1.0
        return told

    def _units(self) -> Floats:
        speed = max(
            1.0,
            math.hypot(*self.begin[[path.SPEED, path.ACROSS]]) if self.start.off_a_wall else 0.0,
        )
        speed = max(speed, float(self.begin[path.SPEED]))
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
        own[..., LOGARITHMS] = np.exp(values[..., LOGARITHMS])
        return own

    def logarithmic(self, natural: Floats) -> Floats:
        """Return the fit's numbers from those that `path` takes."""
        values = natural.copy()
        values[LOGARITHMS] = np.log(natural[LOGARITHMS])
        return values

    def near(self, found: Floats) -> NDArray[np.bool_]:
        """Return which places lie within a few radii of the plate."""
        return np.asarray(np.abs(self.heights(found)) < NEAR_RADII * self.radius_px)

    def heights(self, found: Floats) -> Floats:
        """Return how far places lie from the plate along its normal, px, shape (N,)."""
        return np.asarray((found[:, :2] - self.plate) @ self.normal)

    def high(self, flights: Flights) -> NDArray[np.bool_]:
        """Return which places belong to flights that leave the shadow at the plate."""
        if self.start.off_a_wall:
            return np.ones(len(flights.arcs), dtype=bool)
        heights, arcs = self.heights(flights.observed.places), flights.arcs
        # A first guess of a bounce may be off by as much as a low flight rises, their middle less.
        middle = np.median(self.start.places, axis=0)
        heights += np.maximum(0.0, (self.plate - middle) @ self.normal)
        tops = [heights[arcs == k].max(initial=0.0) for k in range(flights.bounces + 1)]
        return np.asarray(np.array(tops)[arcs] > LOW_RADII * self.radius_px)

    def times(self, values: Floats) -> Floats:
        """Return when the ball's row was read in each frame, for each set of numbers."""
        line = self.observed.places[:, 1 if self.view.readout == "columns" else 0]
        return np.asarray(self.observed.times_s + values[..., path.ROW_TIME, None] * line)

    def predict(self, values: Floats, arcs: Ints) -> tuple[Floats, Floats]:
        """Return places and contacts."""
        found, contacts = self.predict_each(values[None], arcs)
        return found[0], contacts[0]

    def predict_each(self, values: Floats, arcs: Ints) -> tuple[Floats, Floats]:
        """Return places and contacts for each set of numbers, shape (P, K).

        Shapes (P, N, 3) and (P, bounces, 6).
        """
        found, contacts, own = self._flown(values, arcs)
        if self.observed.leans is not None:
            found[..., :2] -= self.observed.leans * outlines(own, found)
        return found, contacts

    def _flown(self, values: Floats, arcs: Ints) -> tuple[Floats, Floats, Floats]:
        """Return places as they are before outlines move them, contacts, and numbers of `path`."""
        own = self.natural(values)
        found = np.zeros((len(values), len(arcs), 3))
        contacts = np.zeros((len(values), self.bounces, 6))
        path.places(own, self.times(values), arcs, found, contacts)
        return found, contacts, own

    def taken(self, values: Floats, arcs: Ints) -> Floats:
        """Return what outlines and a smear's uneven light do to places, px, shape (P, N, 2).

        For each set of numbers, shape (P, K).
        """
        level = values.copy()
        level[:, path.BIAS] = 0.0
        bare = self._flown(level, arcs)[0]
        return np.asarray(self.predict_each(values, arcs)[0][..., :2] - bare[..., :2])

    def assign(self, values: Floats, beside_s: float = 0.0) -> tuple[Ints, NDArray[np.bool_]]:
        """Return which flight each place belongs to, and which lie clear of all contacts.

        Parameters
        ----------
        beside_s
            Time before and after a contact in which no place counts, beside that of the exposure.
        """
        times = self.times(values)
        arcs = np.zeros(len(times), dtype=np.intp)
        _, contacts = self.predict(values, arcs)
        begins = contacts[:, 0]
        arcs = np.searchsorted(begins, times).astype(np.intp)
        near = 0.5 * self.exposure + MARGIN * self.view.period_s + beside_s
        clear = np.ones(len(times), dtype=bool)
        stay = max(0.0, float(values[path.STAY]))
        for begin in begins:
            clear &= (times < begin - near) | (times > begin + stay + near)
        # The last flight goes on to a bounce that is not fitted: nothing after it counts.
        last = np.flatnonzero(arcs == self.bounces)
        if len(last) and not self.start.off_a_wall:
            lasts = 2.0 * contacts[-1, 3] / math.exp(values[path.FALL]) / math.cos(self.start.lean)
            again = begins[-1] + stay + lasts
            clear &= times < again - near - LAST_MARGIN * self.view.period_s
        return arcs, clear
