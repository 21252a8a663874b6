"""Flights and bounces fitted to places whose law is known in closed form."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.describing import described
from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Flights, Observed, Start
from analysis.balls.flight.known import Ball
from analysis.balls.flight.problem import Problem
from analysis.balls.systematics import apart_sigmas, whole_sigmas
from tests.unit.analysis.balls.parabolas import (
    BOUNCES,
    FALL,
    PLATE,
    RATE,
    SCALE,
    known,
    parabolas,
    start,
)


def coefficients(flights: Flights) -> list[tuple[float, float]]:
    told = []
    for contact, slopes in zip(flights.contacts, flights.contact_slopes, strict=True):
        e = contact[3] / contact[1]
        slope = slopes[3] / contact[1] - e * slopes[1] / contact[1]
        told.append((e, math.sqrt(slope @ flights.covariance @ slope)))
    return told


def bounces_of(flights: Flights | None) -> int:
    return 0 if flights is None else flights.bounces


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_bounces_of_a_ball_in_a_vacuum_are_found_within_their_errors(seed: int) -> None:
    flights = fit_flights(parabolas(np.random.default_rng(seed)), start(), known())
    assert flights is not None
    assert flights.bounces == 2
    for (e, sigma), (time, down, up), contact in zip(
        coefficients(flights), BOUNCES, flights.contacts, strict=True
    ):
        assert e == pytest.approx(up / down, abs=4 * sigma)
        assert sigma < 0.002
        assert contact[0] == pytest.approx(time, abs=2e-4)
        assert contact[1] / flights.scale_px_per_m == pytest.approx(down, rel=0.003)


def test_no_contact_lasts_for_less_than_no_time() -> None:
    # The noise of places of a ball that is hard makes it seem to leave before it has come.
    for seed in range(20, 26):
        flights = fit_flights(parabolas(np.random.default_rng(seed)), start(), known())
        assert flights is not None
        lasts = float(flights.values[path.STAY])
        sigma = math.sqrt(flights.covariance[path.STAY, path.STAY])
        # A mean of what is left of a normal distribution above nothing.
        assert 0 < lasts < 2.5 * sigma < 1e-3


def test_a_diameter_that_contradicts_gravity_is_told_and_left_out() -> None:
    flights = fit_flights(parabolas(np.random.default_rng(4)), start(), known(diameter_m=0.06))
    assert flights is not None
    assert flights.contradiction
    assert flights.disagreement == pytest.approx(math.log(1.5), abs=0.01)
    assert flights.scale_px_per_m == pytest.approx(SCALE, rel=0.005)
    assert flights.contacts[0, 3] / flights.contacts[0, 1] == pytest.approx(1.9 / 2.4, abs=0.002)


def test_frames_exposed_during_a_contact_do_not_count() -> None:
    observed = parabolas(np.random.default_rng(5))
    flights = fit_flights(observed, start(), known(exposure_s=0.004))
    assert flights is not None
    near = [np.abs(flights.observed.times_s - time) < 0.002 for time, _, _ in BOUNCES]
    assert any(each.any() for each in near)
    assert not flights.used[near[0] | near[1]].any()


def test_a_bounce_with_too_few_frames_behind_it_ends_the_chain() -> None:
    observed = parabolas(np.random.default_rng(6))
    short = observed.of(observed.times_s < BOUNCES[1][0] + 2.5 / RATE)
    flights = fit_flights(short, start(), known())
    assert flights is not None
    assert flights.bounces == 1


def test_frames_at_a_bounce_that_is_not_fitted_do_not_bend_the_flight_before_it() -> None:
    law = [*BOUNCES, (BOUNCES[1][0] + 2 * 1.45 / 9.80665, 1.45, 1.1)]
    third = law[2][0]
    seen = parabolas(np.random.default_rng(6), law, third + 3.5 / RATE)
    # While the ball is in contact it is exposed before and after: its middle lies too high.
    near = np.abs(seen.times_s - third) < 1.0 / RATE
    seen.places[near, 0] -= 1.5
    flights = fit_flights(seen, start(law), known(exposure_s=1.9 / RATE))
    assert flights is not None
    assert flights.bounces == 2
    assert not np.isin(flights.observed.frames, np.flatnonzero(near)).any()
    for (e, sigma), (_, down, up) in zip(coefficients(flights), law[:2], strict=True):
        assert e == pytest.approx(up / down, abs=4 * sigma)


def test_no_bounce_with_frames_on_both_sides_gives_none() -> None:
    observed = parabolas(np.random.default_rng(7))
    before = observed.of(observed.times_s < BOUNCES[0][0])
    assert fit_flights(before, start(), known()) is None


def test_no_places_give_no_flights() -> None:
    nowhere = parabolas(np.random.default_rng(7)).of(np.zeros(228, dtype=bool))
    assert fit_flights(nowhere, start(), known()) is None


def test_places_that_were_fitted_with_a_wrong_radius_are_put_right() -> None:
    seen = parabolas(np.random.default_rng(8))
    # Of the light ball only the lower rim is seen before a light part of the wall.
    leans = np.zeros_like(seen.places)
    leans[seen.places[:, 0] < 330.0, 0] = -20.0
    wrong = replace(seen, places=seen.places - 0.05 * leans, leans=leans)
    flights = fit_flights(wrong, start(), replace(known(), radius_sigma_px=1.0))
    plain = fit_flights(replace(wrong, leans=None), start(), known())
    assert flights is not None
    assert plain is not None
    true = np.array([up / down for _, down, up in BOUNCES])
    (e, sigma), (other, _) = (np.array(coefficients(each)).T for each in (flights, plain))
    assert (np.abs(e - true) < 3 * sigma).all()
    assert np.abs((other - true) / sigma).max() > 2.5
    outline, spread = path.OUTLINE, math.sqrt(flights.covariance[path.OUTLINE, path.OUTLINE])
    assert abs(flights.values[outline] - 0.05) < 3 * spread < 0.015


def test_a_level_plate_stays_level_for_a_camera_that_is_rolled() -> None:
    seen = parabolas(np.random.default_rng(9))
    seen.places[:, 1] = 100.0 + 500.0 * (seen.times_s - BOUNCES[0][0])
    roll = 0.04
    turn = np.array([[math.cos(roll), math.sin(roll)], [-math.sin(roll), math.cos(roll)]])
    pivot = np.array([PLATE, 100.0])
    rolled = replace(seen, places=(seen.places - pivot) @ turn + pivot)
    before = np.array([[SCALE * b[1], 500.0] for b in BOUNCES]) @ turn
    after = np.array([[-SCALE * b[2], 500.0] for b in BOUNCES]) @ turn
    first = replace(start(), before=before, after=after).of(slice(0, 1))
    one = rolled.of(rolled.times_s < BOUNCES[1][0])
    flights = fit_flights(one, first, known())
    assert flights is not None
    e, sigma = coefficients(flights)[0]
    assert sigma < 0.006
    assert abs(e - BOUNCES[0][2] / BOUNCES[0][1]) < 3 * sigma


def test_a_flight_that_stays_over_its_shadow_ends_the_chain_of_higher_ones() -> None:
    low = 0.34
    begun = BOUNCES[1][0] + 2 * BOUNCES[1][2] / 9.80665
    law = [*BOUNCES, (begun, BOUNCES[1][2], low)]
    seen = parabolas(np.random.default_rng(10), law, begun + 2 * low / 9.80665 - 0.004)
    first = start(law)
    assert bounces_of(fit_flights(seen, first, known())) == 2
    # Where no flight rises higher they are measured as they are.
    large = replace(known(), radius_px=700.0, ball=Ball(1.4, density=7800.0, air_density=0.0001))
    assert bounces_of(fit_flights(seen, first, large)) == 3


def test_a_shift_of_all_places_enlarges_their_errors() -> None:
    flights = fit_flights(parabolas(np.random.default_rng(9)), start(), known())
    assert flights is not None
    shift = np.full_like(flights.observed.places, 0.3)
    sigmas = whole_sigmas(flights, np.stack([shift, *np.zeros((2, *shift.shape))]))
    assert (sigmas > 0.3).all()
    assert (sigmas < 0.31).all()


def test_the_bow_of_an_unknown_focal_length_is_part_of_the_errors_of_places() -> None:
    pulls: list[float] = []
    for seed in range(12):
        rng = np.random.default_rng([11, seed])
        clean, true = parabolas(rng), parabolas(rng, noise=0.0).places
        focal = 479.0 / math.sqrt(0.3 * math.exp(1.2 * rng.standard_normal()))
        longer = 0.5 * ((clean.places - np.array([239.5, 99.5])) / focal) ** 2
        leans = np.tile([-10.0, -5.0], (len(longer), 1))
        seen = replace(clean, places=clean.places - leans * longer, leans=leans)
        flights = fit_flights(seen, start(), known())
        assert flights is not None
        sigmas = apart_sigmas(flights, np.zeros((3, *leans.shape)))
        chosen = np.isin(clean.frames, flights.observed.frames)
        off = flights.observed.places - true[chosen]
        pulls += but_for_shift_and_scale(off, true[chosen], sigmas)[flights.used].ravel().tolist()
    assert 0.7 < np.sqrt(np.mean(np.square(pulls))) < 1.3


def test_places_are_where_a_ball_is_whose_smear_is_brighter_at_one_end() -> None:
    exposure = 0.003
    seen = parabolas(np.random.default_rng(12), noise=0.002)
    true = parabolas(np.random.default_rng(12), noise=0.0).places
    shift = 0.006 * exposure * np.abs(np.gradient(true[:, 0], seen.times_s))
    seen.places[:, 0] += shift
    flights = fit_flights(seen, start(), known(exposure_s=exposure))
    assert flights is not None
    off = (flights.observed.places - true)[flights.used, 0]
    assert shift.max() > 0.04
    assert abs(off.mean()) < 0.3 * shift.mean()


def but_for_shift_and_scale(off: Floats, places: Floats, sigmas: Floats) -> Floats:
    """Errors in their standard errors without what a shift and a scale of all would do."""
    pulls = np.empty_like(off)
    design = np.column_stack([np.ones(len(off)), places])
    for axis in range(2):
        own = design / sigmas[:, axis, None]
        told = np.linalg.lstsq(own, off[:, axis] / sigmas[:, axis], rcond=None)[0]
        pulls[:, axis] = off[:, axis] / sigmas[:, axis] - own @ told
    return pulls


@pytest.mark.parametrize(
    ("fall", "away"), [(1e-12, 1900.0), (FALL, -1900.0), (FALL, 0.0)], ids=["none", "down", "rest"]
)
def test_flights_that_a_fit_tries_on_its_way_have_contacts_in_time(
    fall: float, away: float
) -> None:
    values = np.zeros(path.COMMON + 3 * path.EACH)
    values[[path.TIME, path.SPEED, path.FALL, path.DRAG]] = 0.3, 2400.0, fall, 1e-4
    values[path.HALF] = 240.0
    values[path.COMMON :: path.EACH] = away
    times = np.arange(0, 1.0, 1 / RATE)
    found, contacts = np.zeros((1, len(times), 3)), np.zeros((1, 3, 6))
    arcs = np.zeros(len(times), dtype=np.intp)
    path.places(values[None], times[None], arcs, found, contacts)
    assert np.isfinite(contacts).all()
    # Nothing lasts much longer than the film: its steps are counted in hundredths of a second.
    assert np.abs(contacts[0, :, 0]).max() < 50 * times[-1]


def test_flights_that_run_beyond_all_numbers_are_described_as_far_as_they_go() -> None:
    # A drag that stops a ball within a few px, traced back from its first bounce.
    observed = parabolas(np.random.default_rng(5))
    problem = Problem(observed, start(), known())
    values = problem.begin.copy()
    values[path.DRAG] = math.log(0.05)
    arcs, used = problem.assign(values)
    found = described(problem, values, (arcs, used, np.ones_like(observed.places)))
    assert np.isfinite(found.covariance).all()


def test_a_fall_of_half_the_stated_diameter_is_fitted_from_what_the_flights_say() -> None:
    observed = parabolas(np.random.default_rng(5))
    found = fit_flights(observed, replace(start(), fall=0.95 * FALL), known(diameter_m=0.02))
    assert found is not None
    assert found.contradiction
    # In the stated scale a sphere of 20 px radius is 2000 px/m.
    assert found.scale_of_fall[0] == pytest.approx(SCALE, rel=0.01)
    for (e, sigma), (_, down, up) in zip(coefficients(found), BOUNCES, strict=True):
        assert e == pytest.approx(up / down, abs=4 * sigma + 1e-3)


def test_a_diameter_that_sightings_alone_contradict_counts_again_once_places_are_fitted() -> None:
    observed = parabolas(np.random.default_rng(5))
    found = fit_flights(observed, replace(start(), fall=0.6 * FALL), known())
    assert found is not None
    assert not found.contradiction
    assert found.scale_px_per_m == pytest.approx(SCALE, rel=0.003)


LASTS_S, FIRST = 2e-4, 1.5


def bounces_that_last(power: float) -> list[tuple[float, float, float]]:
    """Begin of each contact, approach speed, and end; three bounces with e = 0.74 in a vacuum."""
    found, begin, speed = [], 0.16, FIRST
    for _ in range(3):
        end = begin + LASTS_S * (speed / FIRST) ** -power
        found.append((begin, speed, end))
        speed *= 0.74
        begin = end + 2 * speed / 9.80665
    return found


def filmed(
    bounces: list[tuple[float, float, float]], rng: np.random.Generator, across: float = 5.0
) -> Observed:
    """Pieces of parabolas between contacts that last; no place is seen during one."""
    times = np.arange(0.05, bounces[-1][2] + 0.1, 1 / 250)
    begins, ends = np.array([(b[0], b[2]) for b in bounces]).T
    after = np.searchsorted(begins, times)
    shown = (after == 0) | (times > ends[after - 1])
    since = np.where(after == 0, times - begins[0], times - ends[after - 1])
    leaving = np.array([FIRST, *(-0.74 * b[1] for b in bounces)])[after]
    rows = PLATE + SCALE * leaving * since + 0.5 * FALL * since**2
    places = np.stack([rows, 100 + across * times], axis=1)[shown]
    sigmas = np.full(places.shape, 0.004)
    places += sigmas * rng.standard_normal(places.shape)
    return Observed(np.arange(len(times))[shown], times[shown], places, sigmas)


@pytest.mark.parametrize("across", [5.0, 100.0], ids=["dropped", "thrown across"])
@pytest.mark.parametrize("power", [0.2, 0.0], ids=["a solid ball", "a linear spring"])
def test_speeds_are_within_their_errors_where_slow_contacts_last_longer(
    power: float, across: float
) -> None:
    """A ball that is thrown across goes on across while a contact lasts."""
    bounces = bounces_that_last(power)
    speeds = np.array([b[1] for b in bounces])
    first = Start(
        np.array([b[0] for b in bounces]) + 0.001,
        np.array([[PLATE + 1.0, 100.0 + 0.2 * across]] * 3),
        np.stack([1.01 * SCALE * speeds, np.full(3, across)], axis=1),
        np.stack([-0.74 * 0.99 * SCALE * speeds, np.full(3, across)], axis=1),
    )
    pulls, off = [], []
    for seed in range(4):
        found = fit_flights(filmed(bounces, np.random.default_rng(seed), across), first, known())
        assert found is not None
        for contact, slopes, speed in zip(
            found.contacts, found.contact_slopes, speeds, strict=True
        ):
            slope = slopes[1].copy()
            slope[path.FALL] -= contact[1]
            sigma = math.sqrt(slope @ found.covariance @ slope)
            pulls.append((contact[1] - found.scale_px_per_m * speed) / sigma)
        off += [(e - 0.74) / sigma for e, sigma in coefficients(found)]
    assert np.sqrt(np.mean(np.square(pulls))) < 1.6
    assert np.sqrt(np.mean(np.square(off))) < 1.6


@pytest.mark.parametrize("slope", [-0.03, 0.02])
def test_later_bounces_on_a_plate_that_slopes_lie_on_the_plate(slope: float) -> None:
    # Without air a flight over a slope lasts 2 v_n / (g cos) and ends as fast as it began.
    values = np.zeros(path.COMMON + 4 * path.EACH)
    values[[path.SPEED, path.ACROSS, path.FALL, path.TILT]] = 2000.0, -300.0, FALL, slope
    values[[path.PLATE, path.HALF, path.ASLANT]] = PLATE, 240.0, 0.1
    values[path.COMMON :: path.EACH] = 1800.0, 1500.0, 1300.0, 1100.0
    values[path.COMMON + 1 :: path.EACH] = -250.0
    found, contacts = np.zeros((1, 2, 3)), np.zeros((1, 4, 6))
    path.places(values[None], np.array([[0.0, 2.0]]), np.array([0, 4]), found, contacts)
    times, towards, away = contacts[0][:, [0, 1, 3]].T
    assert np.diff(times) == pytest.approx(2 * away[:-1] / (FALL * math.cos(slope)))
    assert towards[1:] == pytest.approx(away[:-1])


def test_each_flight_asked_for_alone_begins_where_the_ball_leaves_the_plate() -> None:
    law = [*BOUNCES, (BOUNCES[1][0] + 2 * 1.45 / 9.80665, 1.45, 1.1)]
    flights = fit_flights(parabolas(np.random.default_rng(6), law, 1.15), start(law), known())
    assert flights is not None
    assert flights.bounces == 3
    for k, (time, _, _) in enumerate(law):
        row, column, _ = flights.at(np.array([time]), np.array([k]))[0]
        assert row == pytest.approx(PLATE, abs=0.5)
        assert column == pytest.approx(100 + 20 * time, abs=0.5)
        # Where the ball was free for a moment of this flight, and no other time is asked for.
        after = flights.at(np.array([time + 0.05]), np.array([k + 1]))[0]
        up = law[k][2]
        drawn = PLATE - SCALE * (up * 0.05 - 0.5 * 9.80665 * 0.05**2)
        assert after[0] == pytest.approx(drawn, abs=0.5)


def test_a_fit_of_crude_places_before_it_does_not_hold_the_next_one() -> None:
    observed = parabolas(np.random.default_rng(1))
    fresh = fit_flights(observed, start(), known())
    assert fresh is not None
    values = fresh.values.copy()
    values[path.ASLANT], values[path.PERSPECTIVE], values[path.DEPTH] = 1e-3, -2e-4, 0.2
    values[path.SPEED] *= 1.3
    values[path.COMMON] *= 0.7
    again = fit_flights(observed, start(), known(), replace(fresh, values=values))
    assert again is not None
    assert again.bounces == 2
    for (e, sigma), (_, down, up) in zip(coefficients(again), BOUNCES, strict=True):
        assert e == pytest.approx(up / down, abs=4 * sigma)
        assert sigma < 0.002
