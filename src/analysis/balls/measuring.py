"""From a film to the flights and bounces of one ball."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.films.film import Film, FilmHead
from analysis.balls.flight import path
from analysis.balls.flight.fit import Fit
from analysis.balls.flight.flights import Flights
from analysis.balls.flight.kinds import told_drag
from analysis.balls.flight.known import Ball, Known, View
from analysis.balls.flight.lost import contradicted, find_gap, unsure_e
from analysis.balls.found import Search
from analysis.balls.gaps import Gap, mended
from analysis.balls.hands import free, let_go
from analysis.balls.looking import Looked
from analysis.balls.motions import fitted_motion, seen_motion, windows_of
from analysis.balls.searching import search
from analysis.balls.seen.arcs import Chain
from analysis.balls.seen.looks import Looks
from analysis.balls.seen.placing import Placed, Placer
from analysis.balls.seen.windows import Motion, Seen, Window, cut_windows
from analysis.balls.settling import by_outline, by_sizes, flights_of, last_change
from analysis.balls.surfaces import Part, parts
from analysis.balls.systematics import (
    ByRadius,
    RimsOff,
    apart_sigmas,
    by_radius,
    of_one_flight,
    rims_off,
    shifts,
    whole_sigmas,
)
from analysis.errors import ShotRefusedError

REPEATS, MOST_REPEATS = 3, 5
"""Of learning the ball's light and fitting its flights: at least, and until e has settled."""
SETTLED_E = 1e-3
LEAST_HELD = 0.7
"""Of the places that the fit before holds: a fit of fewer has gone astray."""
LEAST_CODEC_E = 5e-4
"""Standard error of e that a codec leaves beside that of the radius: it moves rims by amounts that
follow the ball's way, which no scatter about flights tells (python -m benchmarks.balls)."""
MOST_GAPS = 6
"""Places at which frames are missing; a film with more has no rate."""


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredBall:
    """Everything that a film says of its ball.

    Attributes
    ----------
    search
        How the ball was found, and what else moves.
    placed
        Its places as fitted, with all that is not known of them.
    scatter
        Standard errors of places beside one another, px, shape (N, 2): without what moves all.
    times_s
        Of all frames.
    exposure_s
        Stated or found from the smear.
    exposure_found
        Its standard error where it was found; None: stated, or too short to be seen.
    flights
        None: no bounce has enough frames on both sides.
    unsettled_e
        By how much e of each bounce changed when the ball's light was learned last; shape (B,).
    unsure_e
        By how much it would change with a time that seems to be missing, and that no whole number
        of frames is; shape (B,).
    head
        Of the film.
    gaps
        Frames that are missing; `times_s` holds the time that they took.
    more_gaps
        Whether frames are missing at more places than are mended.
    outline_e
        By how much e of each bounce depends on where the outline of a ball with patches is where
        these are as light as the ground, shape (B,); None: it has none, or that is not known.
    sizes_e
        By how much e of each bounce would change with the sizes of a ball of unknown mass in a
        compressed film, shape (B,); None: sizes count as they are, or none are known.
    others
        The ball at other surfaces of the same film: walls, and a plate before or after one.
    """

    search: Search
    placed: Placed
    scatter: Floats
    times_s: Floats
    exposure_s: float
    exposure_found: float | None
    flights: Flights | None
    unsettled_e: Floats
    unsure_e: Floats
    head: FilmHead
    gaps: tuple[Gap, ...] = ()
    more_gaps: bool = False
    outline_e: Floats | None = None
    sizes_e: Floats | None = None
    others: tuple[MeasuredBall, ...] = ()

    @property
    def looks(self) -> Looks:
        """Return how the ball looks."""
        return self.search.looks

    @property
    def bounces(self) -> int:
        """Return how many bounces were fitted."""
        return 0 if self.flights is None else self.flights.bounces

    @property
    def surfaces(self) -> list[tuple[MeasuredBall, Flights]]:
        """Return what was measured at each surface, with its flights; this one first."""
        return [(one, one.flights) for one in (self, *self.others) if one.flights is not None]

    @property
    def chain(self) -> Chain:
        """Return the arcs that were found first."""
        return self.search.chain


def measure_ball(
    looked: Looked, times_s: Floats, ball: Ball, exposure_s: float | None
) -> MeasuredBall:
    """Find a ball that flies and bounces, and measure its bounces.

    Where frames are missing and it is certain how many, the film is measured with the times mended.

    Parameters
    ----------
    looked
        The film.
    times_s
        Of its frames, s, shape (frames,).
    exposure_s
        None: found from the smear.

    Raises
    ------
    ShotRefusedError
        No ball, or none that flies freely.
    """
    gaps: list[Gap] = []
    complete, before = False, None
    while True:
        try:
            measured, fits = _measured(looked, times_s, ball, exposure_s, complete=complete)
        except ShotRefusedError:
            if before is None:
                raise
            return before
        if before is not None and measured.bounces < before.bounces:
            return before
        own = measured.search.gaps
        if own and fits and contradicted(fits[-1][-1], own):
            complete = True
            continue
        gaps += own
        gap, unsure = _gap(measured, fits)
        many = gap is not None and len(gaps) >= MOST_GAPS
        before = replace(measured, gaps=tuple(sorted(gaps)), unsure_e=unsure, more_gaps=many)
        if gap is None or many:
            return before
        gaps.append(gap)
        times_s = mended(measured.times_s, [gap])


def _gap(measured: MeasuredBall, fits: Sequence[Fit]) -> tuple[Gap | None, Floats]:
    """Return the surest place at which frames are missing, and what unsure ones do to each e.

    Where bounces were lost, the fit that still had their frames is asked too.
    """
    if not fits:
        return None, measured.unsure_e
    found = find_gap(*fits[-1])
    gap = found.gap
    if gap is None and len(fits) > 1 and measured.bounces < len(measured.chain.times_s):
        gap = find_gap(*fits[0]).gap
    return gap, np.maximum(measured.unsure_e, found.unsure_e)


def _measured(
    looked: Looked, times_s: Floats, ball: Ball, exposure_s: float | None, *, complete: bool
) -> tuple[MeasuredBall, list[Fit]]:
    """Return what a film shows at these times, and what its flights were fitted to each time."""
    found = search(looked, times_s, ball, complete=complete)
    stated = ball, exposure_s
    every = [
        _at_surface(looked.film, replace(found, chain=part.chain), stated, part)
        for part in parts(found.chain, found.fall, ball.plate_lean)
    ]
    # The first surface off which a bounce is measured; of the others those that have one.
    first, fits = next((one for one in every if one[0].bounces), every[0])
    beside = tuple(one for one, _ in every if one is not first and one.bounces)
    return replace(first, others=beside), fits


def _at_surface(
    film: Film, found: Search, stated: tuple[Ball, float | None], part: Part
) -> tuple[MeasuredBall, list[Fit]]:
    """Return the flights about bounces off one surface, and what they were fitted to each time."""
    ball, exposure_s = stated
    looks, chain, times_s = found.looks, found.chain, found.times_s
    start = part.start(found.fall, float(found.fall[0]) if found.contradicts else None)
    period = float(np.median(np.diff(times_s)))
    motion = seen_motion(chain, found.fall)
    placer = Placer.new(looks.radius_px, exposure_s or 0.0, patched=looks.patched)
    longest = period if exposure_s is None else exposure_s
    seen = Seen(found.gains, found.about, found.unexplained)
    looks, windows = _windows(
        placer, looks, motion, lambda ball: cut_windows(film, ball, motion, longest, seen)
    )
    told = None if exposure_s is not None else placer.learn_exposure(windows, motion, period)
    clear = free(placer.place(windows, motion), chain)
    flown = let_go(clear.frames, clear.places[:, 0], (chain, times_s), looks.radius_px)
    bare = placed = clear.of(flown)
    of_radius: ByRadius | None = None
    flights, told_by, earlier, own, row_time = None, placed, placed, windows, 0.0
    drag = ball.drag_per_m()
    by_rims: RimsOff | None = None
    coefficients: list[Floats] = []
    fits: list[Fit] = []
    for repeat in range(MOST_REPEATS if len(chain.times_s) else 0):
        view = _view(film.head, period, placer.exposure_s)
        known = Known(ball, view, looks.radius_px, looks.radius_sigma_px, drag)
        where, guess = (own, motion, row_time), (start, known, flights)
        observed, fitted = flights_of(placer, where, (placed, of_radius), times_s, guess)
        if fitted is None or _lost(fitted, flights, looks.radius_px) or fitted.at_no_wall:
            break
        flights, told_by, earlier = fitted, placed, told_by
        drag = told_drag(ball, flights, drag) if ball.density is None else drag
        fits.append((observed, start, known, fitted))
        coefficients.append(flights.contacts[:, 3] / flights.contacts[:, 1])
        settled = last_change(coefficients).max() < SETTLED_E
        if repeat == MOST_REPEATS - 1 or (settled and repeat + 1 >= REPEATS):
            break
        motion = fitted_motion(flights)
        own = windows_of(windows, motion)
        row_time = float(flights.values[path.ROW_TIME])
        if exposure_s is None:
            told = placer.learn_exposure(own, motion, period)
        by_rims = None if looks.patched else rims_off(looks, motion)
        motion = _learn_light(placer, (own, motion, row_time), by_rims)
        placer.learn_blur(own, motion)
        placed = placer.place(own, motion, row_time)
        if of_radius is None:
            of_radius = by_radius(placer, (own, motion, row_time), placed)
            looks = looks.leaning(of_radius.shifts)
    if flights is None:
        looks, placed, scatter = of_one_flight(
            placer, (windows, motion), placed, (looks, chain.arcs, times_s)
        )
    else:
        placed, scatter = _placed(looks, (bare, earlier, told_by), flights, by_rims)
    measured = MeasuredBall(
        search=replace(found, looks=looks),
        placed=placed,
        scatter=scatter,
        times_s=times_s,
        exposure_s=placer.exposure_s,
        exposure_found=None if told is None else float(told[1]),
        flights=flights,
        unsettled_e=last_change(coefficients),
        outline_e=by_outline(
            placer, (own, motion, row_time), fits, times_s, 0.0 if told is None else told[1]
        ),
        sizes_e=by_sizes(fits, of_radius),
        unsure_e=_unsure(flights),
        head=film.head,
    )
    return measured, [] if start.off_a_wall else fits


def _lost(fitted: Flights, before: Flights | None, radius_px: float) -> bool:
    """Return whether a fit has gone astray.

    It holds far fewer places than the one before, or they lie further off it than the ball reaches.
    """
    far = bool(fitted.residuals[fitted.used, 0].std() > radius_px)
    return far or (before is not None and fitted.used.sum() < LEAST_HELD * before.used.sum())


def _unsure(flights: Flights | None) -> Floats:
    """Return by how much e changes with a time that seems to be missing; none tells it of walls."""
    if flights is None or flights.off_a_wall:
        return np.zeros(0 if flights is None else flights.bounces)
    return unsure_e(flights)


def _windows(
    placer: Placer, looks: Looks, motion: Motion, cut: Callable[[Looks], list[Window]]
) -> tuple[Looks, list[Window]]:
    """Return the ball's looks and windows, with the radius and the blur that explain them best."""
    windows = cut(looks)
    placer.learn_blur(windows, motion)
    if placer.learn_radius(windows, motion):
        looks = looks.with_radius(placer.radius_px)
        windows = cut(looks)
        placer.learn_blur(windows, motion)
    return looks, windows


def _learn_light(
    placer: Placer, seen: tuple[list[Window], Motion, float], rims: RimsOff | None
) -> Motion:
    """Learn the ball's light, where its rims are if that is known; return where it was learned."""
    own, motion, row_time = seen
    if rims is None:
        placer.learn_light(own, motion, row_time)
    else:
        motion = replace(motion, places=motion.places + rims.shift)
        placer.learn_light_at(own, motion, row_time)
    return motion


def _view(head: FilmHead, period_s: float, exposure_s: float) -> View:
    return View(
        *head.whole,
        period_s,
        exposure_s,
        head.readout,
        focal_px=head.focal_px,
        principal_px=head.principal,
        compressed=head.compressed,
    )


def _placed(
    looks: Looks,
    taught: tuple[Placed, Placed, Placed],
    flights: Flights,
    by_rims: RimsOff | None,
) -> tuple[Placed, Floats]:
    """Return places with all that is not known of them, and their errors beside one another."""
    moved = shifts(looks, taught, flights, by_rims)
    own = taught[-1].of(np.isin(taught[-1].frames, flights.observed.frames))
    sigmas = whole_sigmas(flights, moved)
    placed = replace(own, places=flights.observed.places, sigmas=sigmas)
    return placed, apart_sigmas(flights, moved)


def coefficient(measured: MeasuredBall, bounce: int) -> tuple[float, float]:
    """Return e of a bounce and its standard error; `benchmarks.balls` prints its parts."""
    flights = measured.flights
    if flights is None:
        return math.nan, math.inf
    coded = LEAST_CODEC_E if measured.head.compressed else 0.0
    told = float(measured.unsettled_e[bounce]), float(measured.unsure_e[bounce])
    choices = (measured.outline_e, measured.sizes_e)
    chosen = (float(each[bounce]) for each in choices if each is not None)
    e, sigma = flights.coefficient(bounce)
    return e, math.hypot(sigma, *told, *chosen, coded)
