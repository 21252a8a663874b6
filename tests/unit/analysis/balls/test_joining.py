"""Pieces of one flight become one; flights on the two sides of a bounce stay two."""

from __future__ import annotations

import time

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.balls.falling import flights_of, other_fall, without_jumps
from analysis.balls.seen.arcs import Arc, Chain, Sightings, chains, find_arcs
from analysis.balls.seen.free_fall import falls, flown
from analysis.balls.seen.joining import joined
from analysis.balls.seen.looks import Looks
from tests.unit.cli.falling_ball import bouncing

Floats = NDArray[np.float64]

RATE, FALL, RADIUS, SHAPE = 200.0, np.array([2800.0, 0.0]), 14.0, (400, 200)
SMALL_FALL = np.array([1900.0, 0.0])
"""Of a ball of 6 px."""


def arc(first: int, rows: Floats) -> Arc:
    frames = np.arange(first, first + len(rows))
    places = np.stack([rows, np.full(len(rows), 100.0)], axis=1)
    return Arc(frames, frames / RATE, places, float(len(rows)))


def fallen(speed: float, frames: Floats) -> Floats:
    gone = frames / RATE
    return np.asarray(60.0 + speed * gone + 0.5 * FALL[0] * gone**2)


def test_sightings_that_jump_in_the_middle_of_a_flight_leave_one_flight() -> None:
    before = fallen(100.0, np.arange(30.0))
    after = fallen(100.0, np.arange(30.0, 50.0)) + 3.0
    (whole,) = joined([arc(0, before), arc(30, after)], RADIUS, FALL, SHAPE)
    assert whole.frames.tolist() == list(range(50))


def thrown(first: int, last: int, slows: float) -> Arc:
    """A ball before a telephone of 30 frames/s that the air slows across by a share of its fall."""
    frames = np.arange(first, last)
    gone = frames / 30.0
    rows = 200.0 - 900.0 * gone + 0.5 * FALL[0] * gone**2
    columns = 30.0 + 300.0 * gone - 0.5 * slows * FALL[0] * gone**2
    return Arc(frames, gone, np.stack([rows, columns], axis=1), float(last - first))


def test_a_thrown_ball_that_the_air_slows_has_one_flight() -> None:
    shape = (1000, 1000)
    assert len(joined([thrown(0, 14, 0.12), thrown(14, 20, 0.12)], RADIUS, FALL, shape)) == 1
    # A wall turns a ball within one frame, and more.
    turned = thrown(14, 20, 0.0)
    turned.places[:, 1] = 2.0 * 170.0 - turned.places[:, 1]
    assert len(joined([thrown(0, 14, 0.0), turned], RADIUS, FALL, shape)) == 2


def test_two_pieces_are_one_where_the_parabola_nearest_to_both_says_so() -> None:
    """Asked of a library: of pairs that bend otherwise, turn aside, or jump by some pixels."""
    rng = np.random.default_rng(8)
    shape, told, most = (4000, 4000), [], 0.35 * RADIUS + 1.0
    for _ in range(120):
        missed = int(rng.integers(1, 4))
        first, second = np.arange(12.0), np.arange(12.0) + 11.0 + missed
        gone = np.concatenate([first, second]) / RATE
        bends = FALL[0] * rng.uniform(0.2, 2.5), FALL[0] * rng.normal(0.0, 0.15)
        places = np.stack([2000.0 + 300.0 * gone + 0.5 * bend * gone**2 for bend in bends], axis=1)
        places[12:] += rng.normal(0.0, 4.0, 2)
        pieces = [
            Arc(own.astype(np.intp), own / RATE, places[part], 12.0)
            for own, part in ((first, slice(0, 12)), (second, slice(12, 24)))
        ]
        terms = np.polyfit(gone, places, 2)
        off = np.hypot(*(places - np.vander(gone, 3) @ terms).T).max()
        bend, aside = 2.0 * terms[0] / FALL[0]
        one = off <= most and abs(aside) <= 0.15 and 0.5 < bend < 2.0
        told.append(one)
        assert (len(joined(pieces, RADIUS, FALL, shape)) == 1) == one
    assert 20 < sum(told) < 100


def test_flights_before_and_after_a_bounce_stay_apart() -> None:
    before = fallen(100.0, np.arange(40.0))
    after = before[-1] - fallen(0.0, np.arange(1.0, 30.0))[::-1]
    after += before[-1] - after[0]
    assert len(joined([arc(0, before), arc(40, after)], RADIUS, FALL, SHAPE)) == 2


def test_short_hops_on_a_plate_stay_apart() -> None:
    hop = 300.0 - fallen(0.0, np.abs(np.arange(-5.0, 6.0)))
    hop = hop.min() + hop.max() - hop
    assert len(joined([arc(0, hop), arc(11, hop)], RADIUS, FALL, SHAPE)) == 2


def test_what_rests_is_no_flight_though_its_frames_are_too_few_to_show_how_they_bend() -> None:
    held = np.array([60.002, 60.0, 60.001, 60.0])
    falls = fallen(0.0, np.arange(30.0))
    places = [np.array([[row, 100.0, 1.0]]) for row in [*held, *[np.nan] * 4, *falls]]
    seen = [each[np.isfinite(each[:, 0])] for each in places]
    sightings = Sightings(np.arange(len(seen)) / RATE, seen, SHAPE)
    (found,) = find_arcs(sightings, RADIUS, FALL)
    assert found.frames.tolist() == list(range(8, 38))


def test_falls_are_found_among_much_clutter_in_seconds_of_the_processor() -> None:
    # Every fall takes 40 frames, and is gone from the picture for the rest of its 60.
    rng, frames = np.random.default_rng(5), 1500
    rows = 20.0 + 0.5 * FALL[0] * ((np.arange(frames) % 60) / RATE) ** 2
    clutter = rng.uniform(0.0, 1.0, (frames, 16, 3)) * [*SHAPE, 1.0]
    seen = [
        np.concatenate([each, np.array([[row, 100.0, 9.0]])[: int(row < SHAPE[0] - 20)]])
        for each, row in zip(clutter, rows.tolist(), strict=True)
    ]
    begun = time.process_time()
    found = find_arcs(Sightings(np.arange(frames) / RATE, seen, SHAPE), RADIUS, FALL)
    assert time.process_time() - begun < 20.0
    whole = [arc for arc in found if np.abs(arc.places[:, 1] - 100.0).max() < 6.0]
    assert sum(len(arc.frames) > 30 for arc in whole) == frames // 60


def test_a_light_ball_that_falls_from_the_first_frame_is_not_held_there() -> None:
    # It would fall at 4.5 m/s for ever, before a camera of 60 frames/s.
    gravity, fastest = 3280.0, 1500.0
    times = np.arange(26.0) / 60.0
    rows = 36.0 + fastest**2 / gravity * np.log(np.cosh(gravity * times / fastest))
    held = np.concatenate([np.full(9, 36.0), rows])
    for each, first in ((rows, 0), (held, 9)):
        frames = np.arange(len(each))
        places = np.stack([each, np.full(len(each), 100.0)], axis=1)
        one = Arc(frames, frames / 60.0, places, 1.0)
        (kept,) = flown(Chain((one,), np.zeros(0), np.zeros((0, 2))), 20.0).arcs
        assert abs(int(kept.frames[0]) - first) <= (0 if first == 0 else 6)


def test_a_fast_flight_that_is_followed_over_its_bounce_still_falls() -> None:
    # In 36 frames at 1000 a second gravity bends the flight by 3.3 px, less than two places beyond
    # the bounce do.
    fall, gone = np.array([21800.0, 0.0]), np.arange(36.0) / 1000.0
    rows = 30.0 + 3200.0 * gone + 0.5 * fall[0] * gone**2
    turned = rows[-1] - np.array([3.0, 9.0])
    frames = np.arange(38)
    places = np.stack([np.concatenate([rows, turned]), np.full(38, 60.0)], axis=1)
    flight = Arc(frames, frames / 1000.0, places, 38.0)
    chain = Chain((flight,), np.zeros(0), np.zeros((0, 2)))
    looks = Looks(26.0, 0.2, np.ones((6, 1)), np.ones((1, 1)), np.ones(1), ())
    assert falls(chain, looks, fall)
    # A ball that is carried at one speed does not fall.
    carried = np.stack([30.0 + 3200.0 * frames / 1000.0, np.full(38, 60.0)], axis=1)
    steady = Chain((Arc(frames, frames / 1000.0, carried, 38.0),), np.zeros(0), np.zeros((0, 2)))
    assert not falls(steady, looks, fall)


def test_what_trembles_on_its_place_does_not_fall_though_it_bends_as_falls_do() -> None:
    # A leaf before a camera that shakes: two bows 3 px high in 20 frames, of a fall and a bounce.
    fall, looks = (
        np.array([2400.0, 0.0]),
        Looks(8.0, 0.2, np.ones((6, 1)), np.ones((1, 1)), np.ones(1), ()),
    )
    gone = np.arange(-10.0, 11.0) / RATE
    bow = 225.0 + 0.5 * fall[0] * gone**2
    arcs = arc(0, bow), arc(21, bow)
    assert not falls(Chain(arcs, np.array([0.1]), np.array([[228.0, 100.0]])), looks, fall)
    # As high a bow of a ball that has fallen from far above is one of its bounces.
    high = arc(0, fallen(0.0, np.arange(30.0)))
    assert falls(Chain((high, arc(30, bow)), np.array([0.15]), np.zeros((1, 2))), looks, fall)


def test_two_things_that_stand_still_are_no_flight_from_one_to_the_other() -> None:
    """Three frames at one and the next at the other bend as a fall does, within its tolerance."""
    rate, radius, fall = 30.0, 30.0, np.array([8700.0, 0.0])
    places = [(492.0, 251.0, 0.6), (526.0, 253.0, 0.6)]
    noise = 0.3 * np.random.default_rng(3).standard_normal((120, 2, 2))
    seen = [np.array(places) + np.pad(each, ((0, 0), (0, 1))) for each in noise]
    sightings = Sightings(np.arange(120) / rate, seen, (720, 1280))
    assert find_arcs(sightings, radius, fall) == []


def test_what_goes_hither_and_thither_does_not_fall_though_pieces_of_falls_go_through_it() -> None:
    """A hand that holds a ball, before a camera of 30 frames/s."""
    rate, radius, fall = 30.0, 30.0, np.array([8700.0, 0.0])
    rng, looks = (
        np.random.default_rng(4),
        Looks(radius, 0.2, np.ones((6, 1)), np.ones((1, 1)), np.ones(1), ()),
    )
    way = 400.0 + np.cumsum(rng.normal(0.0, 10.0, (300, 1, 2)), axis=0)
    fingers = way + rng.normal(0.0, 30.0, (300, 4, 2))
    seen = list(np.insert(fingers, 2, 1.0, axis=2))
    sightings = Sightings(np.arange(300) / rate, seen, (9999, 9999))
    pieces = chains(find_arcs(sightings, radius, fall), radius, fall)
    assert sum(len(one.arcs) for one in pieces) > 10
    assert not any(falls(one, looks, fall) for one in pieces)
    # A ball that bounces as low is seen in as few frames, and near its falls.
    gone = np.arange(7.0) / rate
    hop = 300.0 - 870.0 * gone + 0.5 * fall[0] * gone**2 + rng.normal(0.0, 0.8, 7)
    frames = np.arange(7)
    flight = Arc(frames, frames / rate, np.stack([hop, np.full(7, 60.0)], axis=1), 7.0)
    assert falls(Chain((flight,), np.zeros(0), np.zeros((0, 2))), looks, fall)


def hops(bends: list[float], apart: int) -> tuple[Chain, Looks]:
    """A small ball at 10 frames/s: each flight has five sightings, and none between."""
    rate, noise, found = 10.0, np.random.default_rng(5), []
    for k, bend in enumerate(bends):
        frames = np.arange(5) + k * (5 + apart)
        rows = 200.0 + 0.5 * bend * SMALL_FALL[0] * ((np.arange(5) - 2.0) / rate) ** 2
        rows += noise.normal(0.0, 0.15, 5)
        places = np.column_stack([rows, 40.0 + frames + noise.normal(0.0, 0.15, 5)])
        found.append(Arc(frames, frames / rate, places, 5.0))
    looks = Looks(6.0, 0.2, np.ones((6, 1)), np.ones((1, 1)), np.ones(1), ())
    return Chain(tuple(found), np.zeros(len(found) - 1), np.zeros((len(found) - 1, 2))), looks


def test_short_flights_that_bend_alike_and_follow_each_other_are_none_by_chance() -> None:
    """Each one alone might be: a few sightings lie on some fall in any clutter."""
    chain, looks = hops([1.0, 1.0, 0.97, 0.95], apart=0)
    assert falls(chain, looks, SMALL_FALL)
    alone, _ = hops([1.0], apart=0)
    assert not falls(alone, looks, SMALL_FALL)


@pytest.mark.parametrize(
    ("bends", "apart"), [([1.0, 1.0, 0.97, 0.95], 3), ([1.0, 0.75, 1.25, 0.9], 0)]
)
def test_short_pieces_far_apart_or_each_of_its_own_fall_are_no_flights_together(
    bends: list[float], apart: int
) -> None:
    chain, looks = hops(bends, apart)
    assert not falls(chain, looks, SMALL_FALL)


BALL = Looks(RADIUS, 0.3, np.ones((6, 1)), np.ones((1, 1)), np.ones(1), ())


def seen_bouncing(count: int, e: float = 0.8, per_frame: int = 1) -> Sightings:
    """A ball that is seen in each frame to a tenth of a pixel, and goes on to rest."""
    rows = np.array(bouncing(count, e, per_frame))
    noise = 0.1 * np.random.default_rng(1).standard_normal((count, 2))
    places = np.column_stack([rows + noise[:, 0], 60.0 + noise[:, 1], np.ones(count)])
    return Sightings(np.arange(count) / (per_frame * RATE), list(places[:, None]), SHAPE)


@pytest.mark.parametrize("per_frame", [4, 10, 15])
def test_a_camera_that_is_fast_for_the_ball_sees_its_bounce_and_lacks_no_frame(
    per_frame: int,
) -> None:
    seen = seen_bouncing(100 * per_frame, per_frame=per_frame)
    flights = flights_of(seen, BALL, FALL)
    _, gaps, found = without_jumps(seen, BALL, FALL, flights)
    assert gaps == ()
    assert found is not None
    (time,) = found[1].times_s
    # By sightings, of which some lie on the other side of the bounce.
    assert time == pytest.approx((320.0 / FALL[0]) ** 0.5, abs=0.01)


@pytest.mark.parametrize(("e", "per_frame", "bounces"), [(0.3, 4, 1), (0.5, 1, 2), (0.5, 4, 2)])
def test_low_bounces_of_a_ball_that_comes_to_rest_are_found_by_fast_cameras_too(
    e: float, per_frame: int, bounces: int
) -> None:
    """What rises by an eighth of the ball's diameter or more is a flight."""
    seen = seen_bouncing(280 * per_frame, e, per_frame)
    found = flights_of(seen, BALL, FALL)
    assert found is not None
    falls_s = (320.0 / FALL[0]) ** 0.5
    known = falls_s * np.array([1.0, 1.0 + 2.0 * e])[:bounces]
    assert found[1].times_s == pytest.approx(known, abs=0.01)


def test_arcs_that_share_frames_give_each_its_own_side_of_a_bounce_and_no_frame_twice() -> None:
    """The first goes on over the bounce, where the ball's shadow was taken for it."""
    rate, bounce = 10 * RATE, 300
    gone = np.arange(-bounce, 300) / rate
    rows = np.where(gone < 0.0, 700.0 * gone, -560.0 * gone) + 0.5 * FALL[0] * gone**2 + 300.0
    frames = np.arange(len(rows))
    places = np.column_stack([rows, np.full(len(rows), 100.0)])

    def of(first: int, last: int, off: float) -> Arc:
        own = slice(first, last)
        return Arc(frames[own], frames[own] / rate, places[own] + off, 1.0 * (last - first))

    over = of(0, bounce + 2, 0.0), of(bounce, 600, 0.3)
    (chain,) = chains(over, RADIUS, FALL)
    before, after = chain.arcs
    assert abs(int(before.frames[-1]) - bounce) <= 2
    for one in chain.arcs:
        assert np.all(np.diff(one.frames) > 0)
        assert np.all(np.diff(one.times_s) > 0)
    assert {*before.frames.tolist(), *after.frames.tolist()} == set(range(600))


def test_a_piece_from_which_the_ball_leaves_far_faster_than_it_came_is_between_no_bounces() -> None:
    """Sightings that something hides for some frames go through a piece of a fall of their own."""
    before, after = fallen(100.0, np.arange(50.0)), fallen(0.0, np.arange(50.0))[::-1]
    after = after + before[-1] - after[0]
    hidden = np.full(6, before[-1]) - np.array([0.0, 0.3, 0.5, 0.5, 0.3, 0.0])
    pieces = [arc(0, before), arc(50, hidden), arc(56, after[6:])]
    chain = chains(pieces, RADIUS, FALL)[0]
    assert [one.frames[0] for one in chain.arcs] == [0, 56]
    (time,) = chain.times_s
    assert time == pytest.approx(49.5 / RATE, abs=1.5 / RATE)


def test_frames_that_all_have_one_time_have_no_flight() -> None:
    seen = seen_bouncing(20)
    assert flights_of(Sightings(np.zeros(20), seen.places, SHAPE), BALL, FALL) is None


@pytest.mark.parametrize("share", [1 / 64, 0.1, 10.0, 100.0])
def test_a_fall_that_a_rate_or_a_unit_makes_far_too_large_or_too_small_is_found(
    share: float,
) -> None:
    seen = seen_bouncing(150)
    stated = FALL / share
    other = other_fall(seen, BALL, stated, flights_of(seen, BALL, stated))
    assert other is not None
    assert other.share == pytest.approx(share, rel=0.02)


@pytest.mark.parametrize(("e", "per_frame"), [(0.3, 4), (0.8, 1)])
def test_a_ball_that_falls_as_stated_falls_no_other_way_though_it_comes_to_rest(
    e: float, per_frame: int
) -> None:
    seen = seen_bouncing(140 * per_frame, e, per_frame)
    assert other_fall(seen, BALL, FALL, flights_of(seen, BALL, FALL)) is None
