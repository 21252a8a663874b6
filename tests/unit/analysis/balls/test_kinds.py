"""A ball whose mass is not stated may be of any kind of its size, and errors of e are as true."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from analysis.balls.flight import path
from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Flights, Observed, Start
from analysis.balls.flight.kinds import KINDS, contact_time, told_drag
from analysis.balls.flight.known import Ball, Known, View

GRAVITY, AIR, DRAG = 9.80665, 1.2, 0.47
BALLS = {
    "table tennis": (0.040, 0.0027),
    "squash": (0.040, 0.024),
    "rubber": (0.040, 0.037),
    "golf": (0.0427, 0.0459),
    "steel": (0.040, 0.261),
    "tennis": (0.067, 0.058),
    "football": (0.220, 0.430),
    "handball": (0.190, 0.450),
}
"""Diameter in m and mass in kg, of the sports' rules and of the metal."""
DOWN, E, RATE, SIGMA_PX = 4.0, 0.8, 240.0, 0.05


def dropped(diameter: float, mass: float, seed: int) -> tuple[Observed, Start, float]:
    """Places of a ball that falls, bounces and rises (textbook: quadratic drag), and px/m."""
    k = 0.5 * AIR * DRAG * math.pi * (diameter / 2) ** 2 / mass
    root, scale = math.sqrt(GRAVITY * k), 20.0 / (diameter / 2)
    fallen = math.atanh(DOWN * math.sqrt(k / GRAVITY)) / root
    low = math.log(math.cosh(root * fallen)) / k
    up = E * DOWN
    turn = math.atan(up * math.sqrt(k / GRAVITY)) / root
    times = np.arange(0.0, fallen + 1.6 * turn, 1 / RATE)
    gone = times - fallen
    high = np.log(np.cos(root * (turn - gone)) / math.cos(root * turn)) / k
    top = math.log(1 / math.cos(root * turn)) / k
    after = np.where(gone < turn, high, top - np.log(np.cosh(root * (gone - turn))) / k)
    height = np.where(gone < 0, low - np.log(np.cosh(root * times)) / k, after)
    places = np.stack([600.0 - scale * height, np.full(len(times), 150.0)], axis=1)
    places += SIGMA_PX * np.random.default_rng(seed).standard_normal(places.shape)
    clear = np.abs(gone) > 1 / RATE
    frames = np.flatnonzero(clear)
    observed = Observed(frames, times[clear], places[clear], np.full((len(frames), 2), SIGMA_PX))
    speeds = np.array([[scale * DOWN, 0.0]]), np.array([[-scale * up, 0.0]])
    return observed, Start(np.array([fallen]), np.array([[600.0, 150.0]]), *speeds), scale


@pytest.mark.parametrize("kind", BALLS)
def test_e_of_a_ball_of_a_common_kind_without_its_mass_is_within_its_error(kind: str) -> None:
    diameter, mass = BALLS[kind]
    observed, start, _ = dropped(diameter, mass, seed=1)
    ball = Ball(diameter)
    drag = ball.drag_per_m()
    for _ in range(4):
        known = Known(ball, View(640, 300, 1 / RATE, 0.0, focal_px=(5000.0, 10.0)), 20.0, drag=drag)
        flights = fit_flights(observed, start, known)
        assert flights is not None
        drag = told_drag(ball, flights, drag)
    assert flights is not None
    e, sigma = flights.coefficient(0)
    assert abs(e - E) < 1.5 * sigma
    assert sigma < 0.03


@pytest.mark.parametrize("diameter", [0.04, 0.22])
@pytest.mark.parametrize("said", [(0.05, 0.07), (0.12, 0.03), (0.01, 0.02), (-0.02, 0.1)])
def test_flights_with_the_prior_say_what_they_say_with_all_kinds(
    diameter: float, said: tuple[float, float]
) -> None:
    ball = Ball(diameter)
    logs = np.linspace(-10.0, 2.0, 60001)
    drags = np.exp(logs)
    misfit = 0.5 * ((drags - said[0]) / said[1]) ** 2

    def fitted(drag: float, spread: float) -> tuple[float, float]:
        """The likeliest drag with a prior, and its logarithm's error by derivatives."""
        best = float(drags[np.argmin(misfit + 0.5 * ((logs - math.log(drag)) / spread) ** 2)])
        return best, ((best / said[1]) ** 2 + spread**-2) ** -0.5

    kinds = [kind for kind in KINDS if kind.least_m <= diameter <= kind.most_m]
    assert len(kinds) >= 2
    likely = np.zeros(len(logs))
    for kind in kinds:
        middle = math.log(0.75 * AIR * DRAG / (kind.density * diameter))
        spread = math.hypot(kind.spread, 0.05 / DRAG)
        likely += kind.share * np.exp(-0.5 * ((logs - middle) / spread) ** 2) / spread
    likely *= np.exp(-misfit)
    mean = float(likely @ drags / likely.sum())
    error = math.sqrt(float(likely @ (drags - mean) ** 2 / likely.sum()))

    best, sigma = fitted(*ball.drag_per_m())
    covariance = np.zeros((path.DRAG + 1, path.DRAG + 1))
    # Flights hold the longer side of a logarithm's error.
    covariance[path.DRAG, path.DRAG] = math.expm1(sigma) ** 2
    values = np.full(path.DRAG + 1, best)
    flights = SimpleNamespace(values=values, covariance=covariance, scale_px_per_m=1.0)
    again, sigma = fitted(*told_drag(ball, cast("Flights", flights), ball.drag_per_m()))
    assert again == pytest.approx(mean, rel=0.02)
    assert again * math.expm1(sigma) == pytest.approx(error, rel=0.02)


@pytest.mark.parametrize("density", [82.0, 700.0, 1150.0, 7800.0])
def test_a_ball_of_40_mm_whose_flights_say_nothing_may_be_full_of_air_or_solid(
    density: float,
) -> None:
    ball = Ball(0.04)
    prior = ball.drag_per_m()
    covariance = np.zeros((path.DRAG + 1, path.DRAG + 1))
    covariance[path.DRAG, path.DRAG] = math.expm1(prior[1]) ** 2
    values = np.full(path.DRAG + 1, prior[0])
    flights = SimpleNamespace(values=values, covariance=covariance, scale_px_per_m=1.0)
    drag, spread = told_drag(ball, cast("Flights", flights), prior)
    true = 0.75 * AIR * DRAG / (density * 0.04)
    assert abs(true - drag) < 1.4 * drag * math.expm1(spread)


@pytest.mark.parametrize(("said", "sigma"), [(0.151, 0.545), (0.176, 0.448), (0.195, 0.427)])
def test_flights_of_a_light_ball_as_large_as_a_tennis_ball_believe_in_no_ball_of_lead(
    said: float, sigma: float
) -> None:
    # As a telephone's film of such a ball says its drag: far from a tennis ball's 0.017 1/m.
    ball = Ball(0.066)
    covariance = np.zeros((path.DRAG + 1, path.DRAG + 1))
    covariance[path.DRAG, path.DRAG] = sigma**2
    values = np.full(path.DRAG + 1, said)
    flights = SimpleNamespace(values=values, covariance=covariance, scale_px_per_m=1.0)
    prior = ball.drag_per_m()
    for _ in range(2):
        prior = told_drag(ball, cast("Flights", flights), prior)
        assert prior[0] > 0.75 * AIR * DRAG / (11340.0 * 0.066)


@pytest.mark.parametrize("ball", ["football", "handball"])
def test_a_large_ball_whose_flights_say_nothing_is_slowed_as_those_that_are_full_of_air(
    ball: str,
) -> None:
    diameter, mass = BALLS[ball]
    prior = Ball(diameter).drag_per_m()
    covariance = np.zeros((path.DRAG + 1, path.DRAG + 1))
    covariance[path.DRAG, path.DRAG] = math.expm1(prior[1]) ** 2
    values = np.full(path.DRAG + 1, prior[0])
    flights = SimpleNamespace(values=values, covariance=covariance, scale_px_per_m=1.0)
    drag, spread = told_drag(Ball(diameter), cast("Flights", flights), prior)
    true = 0.125 * math.pi * AIR * DRAG * diameter**2 / mass
    assert abs(math.log(drag / true)) < 1.5 * spread
    assert spread < 0.5


def test_a_ball_of_a_size_of_no_special_kind_keeps_what_is_believed_of_any() -> None:
    ball = Ball(0.02)
    assert told_drag(ball, cast("Flights", None), ball.drag_per_m()) == ball.drag_per_m()


LASTS_S = {
    "table tennis": 0.8e-3,
    "squash": 4e-3,
    "golf": 0.45e-3,
    "steel": 0.05e-3,
    "tennis": 5e-3,
    "football": math.pi * math.sqrt(0.430 / (2 * math.pi * 0.110 * 0.8e5)),
    "handball": math.pi * math.sqrt(0.450 / (2 * math.pi * 0.095 * 0.4e5)),
}
"""Contacts: measured ones of sports, and half a period of a shell of mass and pressure."""


@pytest.mark.parametrize("weighed", [True, False])
@pytest.mark.parametrize("kind", LASTS_S)
def test_contacts_of_common_balls_are_as_long_as_is_known_beforehand(
    kind: str, weighed: bool
) -> None:
    diameter, mass = BALLS[kind]
    density = mass / (math.pi / 6 * diameter**3) if weighed else None
    middle, sigma = contact_time(Ball(diameter, density=density))
    assert abs(LASTS_S[kind] - middle) < 2.5 * sigma


def test_a_hard_ball_of_the_size_of_a_football_is_none_that_is_full_of_air() -> None:
    assert contact_time(Ball(0.22, density=7000.0)) == pytest.approx((0.0, 5.5e-3), abs=1e-4)


@pytest.mark.parametrize("weighed", [True, False])
def test_a_tennis_ball_comes_as_fast_as_it_does_though_its_contact_lasts(weighed: bool) -> None:
    # In a vacuum: two bounces of 5 ms, parabolas between them.
    rate, scale, lasts, sigma = 480.0, 400.0, 5e-3, 0.3
    came, left = (3.0, 2.2), (2.2, 1.6)
    begins = 0.3, 0.3 + lasts + 2 * left[0] / GRAVITY
    times = np.arange(0.0, begins[1] + 0.3, 1 / rate)
    down = np.zeros(len(times))
    flown = np.full(len(times), True)
    for k, (begin, until) in enumerate(((-1.0, begins[0]), (begins[0] + lasts, begins[1]))):
        since = times - (begins[0] if k == 0 else begin)
        speed = came[0] if k == 0 else -left[0]
        own = (times > begin) & (times < until)
        down[own] = (speed * since + GRAVITY * since**2 / 2)[own]
    last = times > begins[1] + lasts
    since = times - begins[1] - lasts
    down[last] = (-left[1] * since + GRAVITY * since**2 / 2)[last]
    for begin in begins:
        flown &= ~((times > begin - 1 / rate) & (times < begin + lasts + 1 / rate))
    places = np.stack([600.0 + scale * down, np.full(len(times), 150.0)], axis=1)
    places += sigma * np.random.default_rng(5).standard_normal(places.shape)
    kept = np.flatnonzero(flown)
    seen = Observed(kept, times[kept], places[kept], np.full((len(kept), 2), sigma))
    level = np.zeros(2)
    start = Start(
        np.array(begins),
        np.full((2, 2), [600.0, 150.0]),
        scale * np.stack([came, level], axis=1),
        -scale * np.stack([left, level], axis=1),
    )
    density = 370.0 if weighed else None
    ball = Ball(0.067, density=density, air_density=1e-4)
    view = View(900, 300, 1 / rate, 0.0, focal_px=(5000.0, 10.0))
    flights = fit_flights(seen, start, Known(ball, view, 0.0335 * scale))
    assert flights is not None
    for bounce, true in enumerate(came):
        slope = flights.contact_slopes[bounce, 1]
        error = math.sqrt(slope @ flights.covariance @ slope)
        assert abs(flights.contacts[bounce, 1] - scale * true) < 2.0 * error
        assert error < 0.03 * scale * true
