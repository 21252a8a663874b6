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
from analysis.balls.flight.kinds import KINDS, told_drag
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
    assert len(kinds) == 2
    likely = np.zeros(len(logs))
    for kind in kinds:
        middle = math.log(0.75 * AIR * DRAG / (kind.density * diameter))
        spread = math.hypot(kind.spread, 0.05 / DRAG)
        likely += np.exp(-0.5 * ((logs - middle) / spread) ** 2) / spread
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


def test_a_ball_of_a_size_of_no_special_kind_keeps_what_is_believed_of_any() -> None:
    ball = Ball(0.02)
    assert told_drag(ball, cast("Flights", None), ball.drag_per_m()) == ball.drag_per_m()
