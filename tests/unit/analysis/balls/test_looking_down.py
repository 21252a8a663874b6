"""Flights that drift away from a camera which looks down, projected point by point."""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.drift import drift
from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Flights, Observed, Start
from analysis.balls.flight.known import Ball, Known, View

FOCAL, LOOK, AWAY_M, ABOVE_M = 700.0, 0.06, 1.5, 0.25
DRIFT, ACROSS = 0.03, 0.05
RATE, NOISE, RADIUS = 240.0, 0.004, 20.0
G = 9.80665
BOUNCES = [(0.3, 2.4, 1.9), (0.3 + 2 * 1.9 / G, 1.9, 1.45)]
SIZE_NOISE = 1e-3
LEAN_PX = -18.0
"""Of a place, by a relative change of the outline: only the lower rim is seen."""


def ahead_and_place(
    times: Floats, drift: float | None = None, kept: float = 1.0
) -> tuple[Floats, Floats]:
    """Return distances along the line of sight, and rows and columns that a pinhole sees.

    A ball keeps a share of its drift at each bounce.
    """
    up = np.empty(len(times))
    for k, t in enumerate(times):
        past = [b for b in BOUNCES if b[0] <= t]
        begun, rises = (past[-1][0], past[-1][2]) if past else (BOUNCES[0][0], -BOUNCES[0][1])
        up[k] = rises * (t - begun) - 0.5 * G * (t - begun) ** 2
    begun, again = BOUNCES[0][0], BOUNCES[-1][0]
    gone = np.minimum(times - begun, 0.0) + kept * np.clip(times - begun, 0.0, again - begun)
    speed = DRIFT if drift is None else drift
    y, z = up - ABOVE_M, AWAY_M + speed * (gone + kept**2 * np.maximum(times - again, 0.0))
    ahead = math.cos(LOOK) * z - math.sin(LOOK) * y
    over = math.sin(LOOK) * z + math.cos(LOOK) * y
    return ahead, np.stack(
        [239.5 - FOCAL * over / ahead, 99.5 + FOCAL * ACROSS * (times - 0.5) / ahead], axis=1
    )


def observed(seed: int, *, round_of_one_size: bool) -> Observed:
    """Places as they are, or as a fit with one radius for all gives them."""
    times = np.arange(0, 0.95, 1 / RATE)
    ahead, places = ahead_and_place(times)
    at_contact = float(ahead_and_place(np.array([BOUNCES[0][0]]))[0][0])
    rng = np.random.default_rng(seed)
    leans = np.zeros_like(places)
    if round_of_one_size:
        leans[:, 0] = LEAN_PX
        # Across the line of sight a sphere is seen longer by half of the squared tangent.
        longer = 0.5 * ((places[:, 0] - 239.5) / FOCAL) ** 2
        places[:, 0] -= LEAN_PX * (at_contact / ahead - 1.0 + longer)
    places = places + NOISE * rng.standard_normal(places.shape)
    return Observed(np.arange(len(times)), times, places, np.full(places.shape, NOISE), leans)


def fitted(
    seen: Observed,
    focal_px: tuple[float, float] | None = None,
    corner: tuple[float, float] = (0.0, 0.0),
) -> Flights:
    times = np.array([b[0] for b in BOUNCES])
    scale = FOCAL / AWAY_M
    across = np.full(len(BOUNCES), scale * ACROSS)
    down = np.stack([[scale * b[1] * 1.01 for b in BOUNCES], across], axis=1)
    up = np.stack([[-scale * b[2] * 0.99 for b in BOUNCES], across], axis=1)
    places = ahead_and_place(times)[1] - corner
    ball = Ball(2 * RADIUS / scale, density=7800.0, air_density=0.0001)
    principal = 239.5 - corner[0], 99.5 - corner[1]
    view = View(480, 200, 1 / RATE, 0.0, focal_px=focal_px, principal_px=principal)
    known = Known(ball, view, radius_px=RADIUS)
    found = fit_flights(seen, Start(times + 0.0005, places, down, up), known)
    assert found is not None
    return found


def beside(flights: Flights) -> tuple[Floats, Floats]:
    """Return speeds beside the normal, before and after each bounce, m/s, and their errors."""
    scale = flights.scale_px_per_m
    slopes = flights.contact_slopes[:, [2, 4]]
    variances = np.einsum("bkp,pq,bkq->bk", slopes, flights.covariance, slopes)
    return flights.contacts[:, [2, 4]] / scale, np.sqrt(variances) / scale


@pytest.mark.parametrize("round_of_one_size", [False, True], ids=["as they are", "of one radius"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_level_plate_is_level_though_a_ball_drifts_away_over_it(
    round_of_one_size: bool, seed: int
) -> None:
    flights = fitted(observed(seed, round_of_one_size=round_of_one_size))
    tilt_sigma = math.sqrt(flights.covariance[path.TILT, path.TILT])
    assert abs(flights.values[path.TILT]) < 3 * tilt_sigma
    speeds, sigmas = beside(flights)
    assert (np.abs(speeds - ACROSS) < 3 * sigmas).all()
    # No more than a plate that is level by eye leaves open.
    assert sigmas.max() < 0.075


def test_friction_may_take_much_of_a_fast_drift_at_each_bounce() -> None:
    pulls = []
    for seed in range(4):
        times = np.arange(0, 0.95, 1 / RATE)
        _, places = ahead_and_place(times, drift=0.2, kept=0.62)
        places = places + 5 * NOISE * np.random.default_rng(seed).standard_normal(places.shape)
        sigmas = np.full(places.shape, 5 * NOISE)
        flights = fitted(Observed(np.arange(len(times)), times, places, sigmas))
        for bounce, (_, down, up) in enumerate(BOUNCES):
            slopes, (_, came, _, left, *_) = flights.slopes_of_e(bounce), flights.contacts[bounce]
            sigma = math.sqrt(slopes @ flights.whole_covariance @ slopes)
            pulls.append((left / came - up / down) / sigma)
    assert np.sqrt(np.mean(np.square(pulls))) < 2.0


def test_outlines_held_round_and_of_one_size_are_taken_out_of_the_places() -> None:
    seen = observed(3, round_of_one_size=True)
    flights = fitted(seen)
    off = flights.observed.places - ahead_and_place(seen.times_s)[1]
    used = flights.used
    # But for a shift, which flights do not tell.
    assert np.std(off[used, 0]) < 0.03
    assert np.std(seen.places[used, 0] - ahead_and_place(seen.times_s)[1][used, 0]) > 0.15


def test_a_focal_length_that_is_known_makes_speeds_across_exact() -> None:
    flights = fitted(observed(5, round_of_one_size=False), (FOCAL, 0.01 * FOCAL))
    speeds, sigmas = beside(flights)
    assert (np.abs(speeds - ACROSS) < 3 * sigmas).all()
    _, unknown = beside(fitted(observed(5, round_of_one_size=False)))
    assert sigmas.max() < 0.6 * unknown.max()


def test_the_part_of_a_picture_that_is_looked_at_changes_nothing_but_where_rows_begin() -> None:
    seen, corner = observed(6, round_of_one_size=True), (130.0, 40.0)
    part = replace(seen, places=seen.places - corner)
    whole, cut = fitted(seen), fitted(part, corner=corner)
    for found, expected in zip(beside(cut), beside(whole), strict=True):
        assert found == pytest.approx(expected, rel=1e-4)
    assert cut.observed.places + corner == pytest.approx(whole.observed.places, abs=1e-4)


@pytest.mark.parametrize("away", [-0.04, 0.04])
def test_e_of_one_bounce_holds_the_rise_of_what_drifts_away_before_a_long_lens(
    away: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A long lens that looks down sees what drifts away rise: 1.1 px/s here, of 1120 px/s.
    monkeypatch.setattr(sys.modules[__name__], "FOCAL", 1900.0)
    monkeypatch.setattr(sys.modules[__name__], "AWAY_M", 4.0)
    monkeypatch.setattr(sys.modules[__name__], "DRIFT", away)
    monkeypatch.setattr(sys.modules[__name__], "BOUNCES", BOUNCES[:1])
    seen = observed(7, round_of_one_size=False)
    flights = fitted(seen.of(seen.times_s < 0.65))
    _, down, up = BOUNCES[0]
    slope = flights.slopes_of_e(0)
    sigma = math.sqrt(slope @ flights.whole_covariance @ slope)
    off = float(flights.contacts[0, 3] / flights.contacts[0, 1]) - up / down
    assert abs(off) < 2.3 * sigma
    assert sigma < 0.01
    open_rate = math.sqrt(flights.covariance[path.DEPTH, path.DEPTH])
    # Beside its size in each frame: how fast it drifts is known.
    rng = np.random.default_rng(8)
    ahead, _ = ahead_and_place(seen.times_s)
    noise = SIZE_NOISE * rng.standard_normal(len(ahead))
    sizes = np.stack([ahead.mean() / ahead - 1.0 + noise, np.full(len(ahead), SIZE_NOISE)], axis=1)
    sized = fitted(replace(seen, sizes=sizes).of(seen.times_s < 0.65))
    slope = sized.slopes_of_e(0)
    known = math.sqrt(slope @ sized.whole_covariance @ slope)
    off = float(sized.contacts[0, 3] / sized.contacts[0, 1]) - up / down
    assert abs(off) < 2.3 * known
    rate, rate_sigma = sized.values[path.DEPTH], math.sqrt(sized.covariance[path.DEPTH, path.DEPTH])
    assert abs(rate - away / AWAY_M) < 3 * rate_sigma
    assert rate_sigma < open_rate


def sizes_of(rates: tuple[float, float], seed: int, *, compressed: bool) -> tuple[Floats, Floats]:
    """Return the rates by sizes, and their errors, of a ball that drifts so about one bounce."""
    rng = np.random.default_rng(seed)
    seen = observed(9, round_of_one_size=False)
    bounce = BOUNCES[0][0]
    gone = seen.times_s - bounce
    sizes = 0.01 - np.where(gone < 0, rates[0], rates[1]) * gone
    # One edge of the ball is lost in a dark part of the wall, the more the lower it is.
    sizes += 3e-4 * (seen.places[:, 0] - 240.0) / RADIUS
    sizes += SIZE_NOISE * rng.standard_normal(len(gone))
    sizes[::9] -= 0.1
    errors = np.full(len(gone), 0.5 * SIZE_NOISE)
    known = Known(Ball(0.04), View(480, 200, 1 / RATE, 0.0, compressed=compressed), RADIUS)
    sized = replace(seen, sizes=np.stack([sizes, errors], axis=1))
    told = drift(sized, np.array([bounce]), np.ones(len(gone), bool), known)
    # With what a line of sight within 0.1 rad can have of a perspective.
    information = told.weights.T @ told.weights + np.diag([0.0, 0.0, (480 / 0.1) ** 2])
    covariance = np.linalg.inv(information)
    return (covariance @ (told.weights.T @ told.target))[:2], np.sqrt(np.diag(covariance))[:2]


@pytest.mark.parametrize("compressed", [False, True])
def test_sizes_show_drifts_before_and_after_a_bounce_within_their_errors(
    compressed: bool,
) -> None:
    rates = (0.03, 0.02)
    pulls = []
    for seed in range(12):
        found, sigmas = sizes_of(rates, seed, compressed=compressed)
        pulls.append((found - rates) / sigmas)
        assert sigmas.max() < (0.05 if compressed else 0.03)
    assert np.abs(pulls).max() < 4


def test_films_without_sizes_say_nothing_of_drifts() -> None:
    seen = observed(9, round_of_one_size=False)
    known = Known(Ball(0.04), View(480, 200, 1 / RATE, 0.0), RADIUS)
    lost = replace(seen, sizes=np.full((len(seen.frames), 2), np.nan))
    for each in (seen, lost):
        told = drift(each, np.array([0.3]), np.ones(len(seen.frames), bool), known)
        assert told.weights.shape == (0, 3)
        assert told.of_all_flights(0.7) == pytest.approx(0.7)


LASTS = np.array([0.5, 0.444, 0.322, 0.242, 0.186])
ACROSS_THEM = np.array([0.08, 0.17, 0.14, 0.18, 0.23])
"""Of flights before a telephone, the first of which is a fall of half of its time: s from bounce to
bounce, and m/s across, which spin changes."""


def before_a_telephone(seed: int) -> tuple[Observed, Start]:
    """Bounces before a telephone that looks down at them; places scatter by ten times their errors.

    The last flight is seen in its first four frames.
    """
    focal, look, off_m, above_m = 2100.0, 0.1, 0.8, 0.2
    begun = np.cumsum(np.concatenate([[-0.2], LASTS]))
    along = np.concatenate([[0.0], np.cumsum(ACROSS_THEM * LASTS)]) - 0.1
    times = np.arange(0.06, begun[-1] - 0.05, 1 / 30.0)

    def places(times: Floats) -> Floats:
        flight = np.clip(np.searchsorted(begun, times, side="right") - 1, 0, len(LASTS) - 1)
        gone = times - begun[flight]
        up = 0.5 * G * gone * (LASTS[flight] - gone) - above_m
        ahead = math.cos(look) * off_m - math.sin(look) * up
        over = math.sin(look) * off_m + math.cos(look) * up
        across = focal * (along[flight] + ACROSS_THEM[flight] * gone) / ahead
        return np.stack([959.5 - focal * over / ahead, 539.5 + across], axis=1)

    bounces = begun[1:-1]
    slopes = [
        (places(bounces + side * 2e-3) - places(bounces + side * 1e-3)) / (side * 1e-3)
        for side in (-1, 1)
    ]
    rng = np.random.default_rng(seed)
    seen = places(times) + rng.standard_normal((len(times), 2))
    observed = Observed(np.arange(len(times)), times, seen, np.full(seen.shape, 0.1))
    return observed, Start(bounces + 1e-3, places(bounces), slopes[0], slopes[1])


@pytest.mark.parametrize("seed", [4, 7])
def test_no_endless_lens_makes_room_for_another_e_of_a_last_flight_of_four_frames(
    seed: int,
) -> None:
    seen, begin = before_a_telephone(seed)
    scale = 2100.0 / 0.8
    view = View(1920, 1080, 1 / 30.0, 0.01, "rows", compressed=True)
    flights = fit_flights(seen, begin, Known(Ball(2 * 52.0 / scale), view, 52.0))
    assert flights is not None
    truth = LASTS[1:] / LASTS[:-1]
    assert flights.bounces == len(truth)
    slope = flights.slopes_of_e(len(truth) - 1)
    sigma = math.sqrt(slope @ flights.whole_covariance @ slope)
    assert flights.contacts[-1, 3] / flights.contacts[-1, 1] == pytest.approx(truth[-1], abs=0.02)
    assert sigma < 0.04


@pytest.mark.parametrize("seed", [4, 7])
def test_sizes_of_a_shadow_beside_the_ball_do_not_bend_the_flights_of_a_telephone_s_film(
    seed: int,
) -> None:
    seen, begin = before_a_telephone(seed)
    # The shadow on a wall makes the ball seem the larger, the lower it is.
    sizes = 2e-4 * (seen.places[:, 0] - 960.0) + 1e-3 * np.random.default_rng(seed).standard_normal(
        len(seen.frames)
    )
    sized = replace(
        seen,
        leans=np.zeros_like(seen.places),
        sizes=np.stack([sizes, np.full(len(sizes), 1e-3)], axis=1),
    )
    view = View(1920, 1080, 1 / 30.0, 0.01, "rows", compressed=True)
    flights = fit_flights(sized, begin, Known(Ball(2 * 52.0 / (2100.0 / 0.8)), view, 52.0))
    assert flights is not None
    truth = LASTS[1:] / LASTS[:-1]
    assert flights.bounces == len(truth)
    for bounce, e in enumerate(truth.tolist()):
        slope = flights.slopes_of_e(bounce)
        sigma = math.sqrt(slope @ flights.whole_covariance @ slope)
        assert abs(flights.contacts[bounce, 3] / flights.contacts[bounce, 1] - e) < 3.0 * sigma
