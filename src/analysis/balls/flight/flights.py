"""What is known of a ball's flights: places as observed, where a fit begins, and what it found."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.known import LEVEL_SIGMA

Ints = NDArray[np.intp]
LEAST_PLACES = 4
"""A flight of fewer frames ends the chain."""
MOST_LEFT_OUT = 0.2
"""Of all places, that lie off the flights or next to a contact."""
STEEP = math.pi / 4.0
"""Angle of a plate, from which on it is a wall."""
SURE = 3.0
"""Errors by which a plate that is not level leans at least."""
LARGE_CHI2 = 400.0
"""Mean square of the residuals in errors that a codec and shading do not make."""
MOST_UNSURE_FALL = 0.1
"""Relative error of gravity in flights by which they are believed to fall otherwise than stated."""


@dataclass(frozen=True, slots=True, eq=False)
class Observed:
    """Places of a ball: frame numbers, times in s, (row, column) and standard errors in px.

    Attributes
    ----------
    frames, times_s, places, sigmas
        Shapes (N,), (N,), (N, 2), (N, 2).
    leans
        Change of each place, as it was fitted with one radius for all, by a relative change of the
        outline, px; shape (N, 2). None: not known.
    sizes
        How much larger the ball is seen in each frame than the radius with which its places were
        fitted, relative, and its standard error; shape (N, 2). Nan, and None for all frames: not
        known.
    bare
        Whether places were fitted before the film has taught the ball's light.
    """

    frames: Ints
    times_s: Floats
    places: Floats
    sigmas: Floats
    leans: Floats | None = None
    sizes: Floats | None = None
    bare: bool = False

    def of(self, chosen: NDArray[np.bool_]) -> Observed:
        """Return some of them."""
        return Observed(
            self.frames[chosen],
            self.times_s[chosen],
            self.places[chosen],
            self.sigmas[chosen],
            None if self.leans is None else self.leans[chosen],
            None if self.sizes is None else self.sizes[chosen],
            self.bare,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where the fit begins: bounces' times, places, speeds before and after.

    Attributes
    ----------
    times_s, places, before, after
        Shapes (B,), (B, 2), (B, 2), (B, 2): s, px, px/s, in (row, column).
    fall
        Free fall, px/s^2, where flights bend otherwise than the stated diameter says; else None.
    lean, lean_sigma
        Angle of the plate against the horizontal and its standard error before the film is seen,
        rad: 0, or a quarter turn of a wall, positive on the left; of a plate that is known to lean
        positive where it lies lower on the right.
    """

    times_s: Floats
    places: Floats
    before: Floats
    after: Floats
    fall: float | None = None
    lean: float = 0.0
    lean_sigma: float = LEVEL_SIGMA

    @property
    def off_a_wall(self) -> bool:
        """Return whether the plate is a wall, to which nothing falls back."""
        return abs(self.lean) > STEEP

    def of(self, chosen: slice) -> Start:
        """Return some of the bounces."""
        return Start(
            self.times_s[chosen],
            self.places[chosen],
            self.before[chosen],
            self.after[chosen],
            self.fall,
            self.lean,
            self.lean_sigma,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Flights:
    """The fitted flights of one film.

    Attributes
    ----------
    values, covariance
        Of all numbers of `path`, shapes (P,) and (P, P); those held fixed have no error. The
        inverse of what places and priors say, without `by_rise`.
    by_rise
        By how much the numbers change with one standard error of the speed at which what drifts
        away from the camera seems to rise, beyond the covariance; shape (P,).
    known_sigmas
        With which each number is known beforehand: 0 where it is held, very large where nothing is
        known; shape (P,).
    off_beliefs
        Sum of the squares, in errors, of what the numbers are off what was known of them.
    early_s
        By how much places alone have contacts end before they have begun, where that is clear;
        else 0.
    drifts
        What the ball's sizes, and friction at bounces, say of drifts along the line of sight, as
        the weights of equations whose errors are 1; shape (M, P).
    contacts, contact_slopes
        Of each bounce as `path.places` gives them, shape (B, 6), and their derivatives to the
        values, shape (B, 6, P).
    observed, arcs, used
        What was fitted, with what outlines and smears did to places taken out; which flight each
        place belongs to, and which places counted.
    slopes, taken_slopes
        Derivatives to the fit's numbers, px, shape (N, 2, P): of where the ball is seen, and of
        what was taken out of places.
    residuals
        Place less model, px, shape (N, 2).
    sigma_scale
        By how much the scatter about the flights exceeds the stated errors, shape (N, 2).
    chi2_per_dof
        With the stated errors of places.
    scale_px_per_m
        From all that is known.
    scale_of_fall
        px/m from the fall alone and its relative standard error.
    scale_of_diameter
        px/m from the diameter alone and its relative standard error.
    contradiction
        Whether the two differ by more than their errors allow; the diameter was then left out.
    readout
        Of the camera, as `View` has it.
    weighed
        Whether the ball's mass is stated.
    """

    values: Floats
    covariance: Floats
    by_rise: Floats
    known_sigmas: Floats
    off_beliefs: float
    early_s: float
    drifts: Floats
    contacts: Floats
    contact_slopes: Floats
    observed: Observed
    slopes: Floats
    taken_slopes: Floats
    arcs: Ints
    used: NDArray[np.bool_]
    residuals: Floats
    sigma_scale: Floats
    chi2_per_dof: float
    scale_px_per_m: float
    scale_of_fall: tuple[float, float]
    scale_of_diameter: tuple[float, float]
    contradiction: bool
    readout: str
    weighed: bool

    @property
    def bounces(self) -> int:
        """Return how many bounces there are."""
        return len(self.contacts)

    @property
    def whole_covariance(self) -> Floats:
        """Return the covariance of the numbers with all that is not known of them."""
        return np.asarray(self.covariance + np.outer(self.by_rise, self.by_rise))

    @property
    def at_no_wall(self) -> bool:
        """Return whether flights about a wall do not fall as stated, and not surely otherwise.

        A hand that moves a ball to and fro turns it as a wall does, and nothing else tells that it
        does not fly.
        """
        unsure = self.contradiction and self.scale_of_fall[1] > MOST_UNSURE_FALL
        return self.off_a_wall and unsure

    @property
    def off_a_wall(self) -> bool:
        """Return whether the plate is a wall, which no flight falls back to."""
        return bool(abs(self.values[path.TILT]) > STEEP)

    @property
    def lean(self) -> float:
        """Return the angle of the plate against the horizontal, rad, as `Start` has it."""
        return float(self.values[path.LEVEL].sum())

    @property
    def lean_sigma(self) -> float:
        """Return the standard error of that angle, rad."""
        return float(np.sqrt(self.whole_covariance[np.ix_(path.LEVEL, path.LEVEL)].sum()))

    @property
    def leans(self) -> bool:
        """Return whether a plate is surely not level, whatever the camera's own roll."""
        return not self.off_a_wall and abs(self.lean) > SURE * max(LEVEL_SIGMA, self.lean_sigma)

    @property
    def next_contact_s(self) -> float:
        """Return when the last flight meets the plate again, s, but for the drag of the air."""
        if self.off_a_wall:
            return math.inf
        along = math.cos(self.lean) * self.values[path.FALL]
        lasts = 2.0 * self.contacts[-1, 3] / along
        stay = max(0.0, float(self.values[path.STAY]))
        return float(self.contacts[-1, 0] + stay + lasts)

    @property
    def lasts_after_next_s(self) -> float:
        """Return how long the flight after that contact lasts with the last bounce's e, s."""
        _, came, _, left, *_ = self.contacts[-1]
        return float(left / came * 2.0 * left / self.values[path.FALL])

    def lost_at_first(self, time_s: float) -> float:
        """Return by how much e of the first bounce falls where so long a time is missing at it.

        After a time T that is not in the film both flights would meet where the ball is slower by
        g T v_n'/(v_n + v_n') and g T v_n/(v_n + v_n'): e falls by g T (1 - e)/v_n.
        """
        _, came, _, left, *_ = self.contacts[0].tolist()
        return float(self.values[path.FALL] * time_s * (1.0 - left / came) / came)

    @property
    def disagreement(self) -> float:
        """Return by how much diameter and gravity differ where they contradict each other, else 0.

        Relative: it may be the ball's radius in the picture that is wrong by as much.
        """
        if not self.contradiction:
            return 0.0
        return abs(math.log(self.scale_of_fall[0] / self.scale_of_diameter[0]))

    @property
    def doubt(self) -> float:
        """Return the share of places off the flights where much lies off them, else 0.

        Times of such a film are none: an e may be off by as much as the share of places that
        flights of one rate leave out.
        """
        share = float(np.mean(~self.used))
        return share if share > MOST_LEFT_OUT or self.chi2_per_dof > LARGE_CHI2 else 0.0

    @property
    def scatter(self) -> Floats:
        """Return standard errors of places beside one another, px, shape (N, 2).

        A place that does not count is as uncertain as it lies off the flights.
        """
        own = self.observed.sigmas * self.sigma_scale
        return np.where(self.used[:, None], own, np.maximum(own, np.abs(self.residuals)))

    def longest_chain(self, high: NDArray[np.bool_]) -> list[int]:
        """Return the neighbouring flights with enough frames that hold the most.

        Of places that leave the shadow at the plate, `high` of shape (N,), where enough do.
        """
        used = self.used & high if (self.used & high).sum() >= LEAST_PLACES else self.used
        counts = [int((used & (self.arcs == k)).sum()) for k in range(self.bounces + 1)]
        # What does not come and go again is no bounce: flights on its two sides are two chains.
        real = np.concatenate([[True], (self.contacts[:, [1, 3]] > 0).all(axis=1)])
        best: list[int] = []
        run: list[int] = []
        for k, count in enumerate(counts):
            run = run if real[k] else []
            run = [*run, k] if count >= LEAST_PLACES else []
            if sum(counts[j] for j in run) > sum(counts[j] for j in best):
                best = run
        return best

    def slopes_of_e(self, bounce: int) -> Floats:
        """Return derivatives of a bounce's e to the fit's numbers, shape (P,)."""
        contact, slopes = self.contacts[bounce], self.contact_slopes[bounce]
        return np.asarray((slopes[3] - contact[3] / contact[1] * slopes[1]) / contact[1])

    def coefficient(self, bounce: int) -> tuple[float, float]:
        """Return e of a bounce, and the standard error that the flights leave.

        What is beyond 1 is error: no ball leaves a plate at rest faster than it came.
        """
        contact, slope = self.contacts[bounce], self.slopes_of_e(bounce)
        variance = float(slope @ self.whole_covariance @ slope)
        e = float(contact[3] / contact[1])
        return e, math.hypot(math.sqrt(variance), self.doubt, max(0.0, e - 1.0))

    def row_delay(self, places: Floats) -> Floats:
        """Return how much later than the first row each place is read, s."""
        line = places[:, 1] if self.readout == "columns" else places[:, 0]
        return np.asarray(self.values[path.ROW_TIME] * line)

    def at(self, times_s: Floats, arcs: Ints) -> Floats:
        """Return row, column and distance at times (of their own rows) in flights, shape (N, 3)."""
        # The film's own ends beside the times: by its length flights from bounce to bounce are cut.
        ends = self.observed.times_s[[0, -1]]
        times = np.concatenate([ends[:1], times_s, ends[1:]])
        flights = np.concatenate([[0], arcs, [self.bounces]])
        found = np.empty((1, len(times), 3))
        contacts = np.empty((1, self.bounces, 6))
        path.places(self.values[None], times[None], flights, found, contacts)
        return found[0, 1:-1]
