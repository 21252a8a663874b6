"""What is said of a film: each thing once, and nothing that contradicts another sentence."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.balls import analysis
from analysis.balls.analysis import analyse_held
from analysis.balls.even import even_stretches, in_doubt
from analysis.balls.films.film import FilmHead, HeldFilm
from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Flights
from analysis.balls.flight.known import Ball
from analysis.balls.found import Search
from analysis.balls.looking import Looked
from analysis.balls.measuring import MeasuredBall, measure_ball
from analysis.balls.remarks import remarks
from analysis.balls.seen.arcs import Arc, Chain
from analysis.balls.seen.looks import Looks
from analysis.balls.seen.placing import Placed
from tests.unit.analysis.balls.parabolas import BOUNCES, PLATE, RATE, known, parabolas, start
from tests.unit.cli import falling_ball
from tests.unit.cli.falling_ball import DIAMETER_MM, bouncing, picture

HEIGHT, WIDTH, RADIUS = 1080, 1920, 46.0


def film_of(
    places: Floats, first: int, outside: Floats, frames: int, flights: Flights | None = None
) -> MeasuredBall:
    """A film in which a ball flies from a frame on, and is seen outside its flight too."""
    flown = np.arange(first, first + len(places))
    chain = Chain((Arc(flown, flown / RATE, places, 1.0),), np.zeros(0), np.zeros((0, 2)))
    times = np.arange(frames) / RATE
    looks = Looks(RADIUS, 0.3, np.ones((6, 1)), np.ones((1, 1)), np.ones(1), ())
    fall = np.array([9806.65, 0.0])
    ones, none = np.ones(frames), np.zeros(0)
    search = Search(looks, chain, fall, (), outside, (), ones, None, False, times, ())
    bounces = 0 if flights is None else flights.bounces
    return MeasuredBall(
        search=search,
        placed=Placed(flown, places, np.ones_like(places), *3 * (ones[: len(flown)],)),
        scatter=np.ones_like(places),
        times_s=times,
        exposure_s=0.0,
        exposure_found=None,
        flights=flights,
        unsettled_e=none if flights is None else np.zeros(bounces),
        unsure_e=none if flights is None else np.zeros(bounces),
        head=FilmHead(frames, HEIGHT, WIDTH, 1, rate_hz=RATE),
    )


def seen_at(frames: range, begin: tuple[float, float], end: tuple[float, float]) -> Floats:
    """Frames and places on a straight way."""
    return np.column_stack([list(frames), np.linspace(begin, end, len(frames))])


def test_a_ball_that_is_held_at_the_border_does_not_enter_the_picture() -> None:
    falls = np.column_stack([104.0 + 45.0 * np.arange(12), np.full(12, 987.0)])
    held = seen_at(range(67), (17.0, 973.0), (60.0, 987.0))
    told = remarks(film_of(falls, 67, held, 79))
    assert sum("frames 0 to 66, the ball or what looks like it is held or rests" in t for t in told)
    assert not any("enters the picture" in each for each in told)
    # Where it is not seen before, it does.
    alone = remarks(film_of(falls, 67, held[:0], 79))
    assert any("enters the picture at frame 67 at (104, 987) px" in each for each in alone)


def test_a_ball_that_is_seen_until_the_border_cuts_it_leaves_there() -> None:
    rows = 400.0 + 5.0 * np.arange(12)
    flies = np.column_stack([rows, WIDTH - 276.0 + 15.0 * np.arange(12)])
    last = (float(rows[-1]), WIDTH - 96.0)
    leaves = seen_at(range(12, 18), last, (last[0] + 30.0, WIDTH - 20.0))
    told = remarks(film_of(flies, 0, leaves, 40))
    assert sum("leaves the picture" in each for each in told) == 1
    assert any("in frames 12 to 17" in each and "leaves the picture" in each for each in told)


def test_a_ball_that_rolls_along_a_border_does_not_cross_it() -> None:
    falls = np.column_stack([300.0 + 4.0 * np.arange(12) ** 2, np.full(12, 300.0)])
    rolls = seen_at(range(20, 70), (HEIGHT - 45.5, 400.0), (HEIGHT - 46.5, 1400.0))
    told = remarks(film_of(falls, 0, rolls, 80))
    assert any("in frames 20 to 69, the ball or what looks like it rolls" in t for t in told)
    assert not any("the picture" in each for each in told)


def test_something_that_is_seen_elsewhere_does_not_keep_a_ball_from_entering() -> None:
    flies = np.column_stack([400.0 + 2.0 * np.arange(12), 104.0 + 45.0 * np.arange(12)])
    elsewhere = seen_at(range(67), (900.0, 1500.0), (905.0, 1505.0))
    told = remarks(film_of(flies, 67, elsewhere, 79))
    assert any("enters the picture at frame 67 at (400, 104) px" in each for each in told)


def test_a_bounce_before_a_flight_of_few_frames_says_so() -> None:
    second, down, _ = BOUNCES[1]
    law = [BOUNCES[0], (second, down, 0.45)]
    third = second + 2 * 0.45 / 9.80665
    observed = parabolas(np.random.default_rng(3), law, third + 0.5 / RATE)
    flights = fit_flights(observed, start(law), known())
    assert flights is not None
    assert flights.bounces == 2
    frames = len(observed.frames) + 40
    later = seen_at(range(frames - 30, frames), (PLATE - 150.0, 130.0), (PLATE - 200.0, 130.0))
    (told,) = (
        each
        for each in remarks(film_of(observed.places, 0, later, frames, flights))
        if "is not measured" in each
    )
    # e of 0.237 makes 5.2 frames of 22.
    assert "the flight after it lasts some 5.2 frames, too few" in told


def test_a_mass_that_is_not_stated_is_asked_for_where_e_is_unsure_for_it() -> None:
    seen = parabolas(np.random.default_rng(4), noise=0.5)
    seen = replace(seen, sigmas=np.full(seen.places.shape, 0.5))
    for ball, asked in ((Ball(0.04), True), (Ball(0.04, density=1000.0), False)):
        flights = fit_flights(seen, start(), replace(known(), ball=ball))
        assert flights is not None
        told = remarks(film_of(seen.places, 0, np.zeros((0, 3)), len(seen.frames), flights))
        assert any("state the mass" in each for each in told) == asked


def test_frames_about_a_bounce_in_which_the_ball_is_not_followed_are_said() -> None:
    rows = np.column_stack([PLATE - 3.0 * np.abs(np.arange(-30.0, 30.0)), np.full(60, 100.0)])
    seen = film_of(rows, 0, np.zeros((0, 3)), 60)
    (whole,) = seen.chain.arcs
    for first, after, told in ((24, 36, True), (29, 31, False)):
        arcs = whole.part(0, first), whole.part(after, 60)
        chain = Chain(arcs, np.array([30 / RATE]), np.array([[PLATE, 100.0]]))
        found = remarks(replace(seen, search=replace(seen.search, chain=chain)))
        own = [each for each in found if "not followed" in each]
        assert len(own) == told
        assert not told or "from frame 24 to frame 35, about bounce 1" in own[0]


def test_places_that_scatter_far_more_than_each_is_uncertain_are_said() -> None:
    seen = parabolas(np.random.default_rng(4), noise=0.1)
    for stated, told in ((0.02, True), (0.1, False)):
        one = replace(seen, sigmas=np.full(seen.places.shape, stated))
        flights = fit_flights(one, start(), known())
        assert flights is not None
        found = remarks(film_of(one.places, 0, np.zeros((0, 3)), len(one.frames), flights))
        own = [each for each in found if "times as far as the light" in each]
        assert len(own) == told
        assert not told or "px about free flights, 5 times as far" in own[0]


def test_stretches_of_a_film_in_which_its_rate_holds_are_told_by_how_the_ball_falls() -> None:
    """For 20 frames after its first bounce a camera takes half as many as its file says."""
    rows = np.array(bouncing(3000, per_frame=10))[::10]
    shown = np.concatenate([rows[:100], rows[100:140:2], rows[140:]])
    frames = np.arange(len(shown), dtype=float)
    seen = np.column_stack([frames, shown, np.full(len(shown), 60.0)])
    film = film_of(np.column_stack([shown[:3], np.full(3, 60.0)]), 0, seen[3:], len(shown))
    looks = replace(film.looks, radius_px=14.0)
    film = replace(film, search=replace(film.search, looks=looks))
    assert in_doubt(film)
    found = even_stretches(film, frames / 200.0, Ball(1e-3 * DIAMETER_MM))
    (a, b), (c, d) = found
    # Bounces are at frames 67.6, 156 and 242.
    assert 110 < a < 130
    assert b > 250
    assert c == 0
    assert 90 < d < 110


def test_a_film_whose_places_scatter_is_measured_once_where_all_flights_keep_its_rate(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Places that scatter by 1.5 px look like frames that are missing, as those of codecs do."""
    seen: list[MeasuredBall] = []

    def kept(looked: Looked, *known: object) -> MeasuredBall:
        seen.append(measure_ball(looked, *known))  # type: ignore[arg-type]
        return seen[-1]

    monkeypatch.setattr(analysis, "measure_ball", kept)
    off = np.random.default_rng(0).normal(0.0, 1.5, 150)
    shown = [picture(row) for row in (np.array(bouncing(150)) + off).tolist()]
    gone = [picture(-100.0)] * 12
    times = np.arange(len(shown) + len(gone)) / falling_ball.RATE
    ball = Ball(1e-3 * DIAMETER_MM)
    found = analyse_held(HeldFilm(Path("film"), np.array(shown + gone)), times, ball, 0.0)
    assert found.measured.bounces == 1
    assert in_doubt(found.measured)
    assert even_stretches(found.measured, times, ball) == [(0, 149)]
    assert seen == [found.measured]


def test_a_ball_that_rises_a_little_when_the_film_ends_does_not_rest() -> None:
    rows = np.column_stack([PLATE - 3.0 * np.abs(np.arange(-30.0, 30.0)), np.full(60, 100.0)])
    for end, does in ((PLATE - 12.0, "rises by less than a radius"), (PLATE - 1.0, "rests")):
        after = seen_at(range(62, 80), (PLATE, 100.0), (end, 100.0))
        seen = film_of(rows, 0, after, 80)
        (whole,) = seen.chain.arcs
        arcs = whole.part(0, 30), whole.part(30, 60)
        chain = Chain(arcs, np.array([30 / RATE]), np.array([[PLATE, 100.0]]))
        told = remarks(replace(seen, search=replace(seen.search, chain=chain)))
        assert any(f"the ball or what looks like it {does}" in each for each in told)
