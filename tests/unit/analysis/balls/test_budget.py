"""What the error of e consists of, in films whose largest source is known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from analysis.balls.flight import path
from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Flights, Observed, Start
from analysis.balls.flight.known import LEVEL_SIGMA, Ball, Known, View
from benchmarks.balls.budget import budget

SCALE, FALL, PLATE, RATE = 1000.0, 9806.65, 400.0, 500.0
CONTACT_S, DOWN, UP = 0.2, 2.0, 1.6


def fitted(across: float, ball: Ball, noise: float = 0.002) -> Flights:
    """One bounce of a ball in a vacuum that flies across at a speed, m/s."""
    times = np.arange(0.0, 0.45, 1 / RATE)
    since = times - CONTACT_S
    leaving = np.where(since < 0, SCALE * DOWN, -SCALE * UP)
    rows = PLATE + leaving * since + 0.5 * FALL * since**2
    places = np.stack([rows, 150.0 + SCALE * across * since], axis=1)
    places += noise * np.random.default_rng(3).standard_normal(places.shape)
    frames = np.arange(len(times))
    observed = Observed(frames, times, places, np.full(places.shape, noise))
    speeds = np.array([[SCALE * DOWN, SCALE * across]]), np.array([[-SCALE * UP, SCALE * across]])
    start = Start(np.array([CONTACT_S + 1e-3]), np.array([[PLATE, 150.0]]), *speeds)
    known = Known(ball, View(480, 300, 1 / RATE, 0.0, focal_px=(5000.0, 10.0)), radius_px=20.0)
    flights = fit_flights(observed, start, known)
    assert flights is not None
    return flights


HEAVY = Ball(0.04, density=7800.0, air_density=1e-4)


def test_a_throw_across_has_the_error_of_its_plate_s_lean() -> None:
    parts = budget(fitted(0.4, HEAVY), 0, 0.01)
    # Turning the normal by q takes q v_t from the speed before and gives it to that after.
    assert parts["level"] == pytest.approx(LEVEL_SIGMA * 0.4 * (1 + UP / DOWN) / DOWN, rel=0.02)
    assert math.hypot(*parts.values()) == pytest.approx(0.01, rel=1e-6)


def test_a_level_fall_has_no_error_of_its_plate_s_lean() -> None:
    parts = budget(fitted(0.0, HEAVY), 0, 0.01)
    assert parts["level"] < 1e-4
    assert list(parts.values()) == sorted(parts.values(), reverse=True)


def test_the_error_of_the_drag_is_in_proportion_to_what_is_stated_of_it() -> None:
    light = [Ball(0.04, density=3000.0, drag_sigma=sigma) for sigma in (0.0, 0.01, 0.02)]
    none, some, more = (budget(fitted(0.0, ball), 0, 0.1)["drag"] for ball in light)
    assert none == 0.0
    assert more == pytest.approx(2 * some, rel=0.2)


@pytest.mark.parametrize("density", [80.0, 1100.0])
def test_an_unknown_mass_may_be_that_of_a_ball_full_of_air_and_of_a_solid_one(
    density: float,
) -> None:
    drag, spread = Ball(0.04).drag_per_m()
    own, _ = Ball(0.04, density=density).drag_per_m()
    assert abs(math.log(own / drag)) < 1.7 * spread


def test_the_drag_of_an_unknown_mass_may_be_larger_by_more_than_it_may_be_smaller() -> None:
    flights = fitted(0.0, Ball(0.04), noise=1.0)
    upward = math.sqrt(flights.covariance[path.DRAG, path.DRAG])
    # Places that scatter so leave the logarithm as open as it was: a factor of e.
    assert upward == pytest.approx(math.expm1(1.0), rel=0.15)
