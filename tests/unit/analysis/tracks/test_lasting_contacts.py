"""A ball in contact before a fast camera: frames in which it does not fly count for no flight."""

from __future__ import annotations

import math

import numpy as np
import pytest

from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Observed, Start
from analysis.balls.flight.known import Ball, Known, View
from benchmarks.balls.dropping import GRAVITY

RATE, DIAMETER, RADIUS_PX, SIGMA_PX = 5000.0, 0.027, 36.0, 0.001
SCALE = 2 * RADIUS_PX / DIAMETER
CAME, LEFT, BEGINS_S = 3.3, 2.8, 11e-3


@pytest.mark.parametrize("lasts_s", [0.3e-3, 2.0e-3])
def test_speeds_are_those_of_free_flight_however_long_a_soft_ball_is_in_contact(
    lasts_s: float,
) -> None:
    # In contact it is pressed in and out again by a spring (half a sine), which ends at LEFT.
    times = np.arange(180) / RATE
    before, after = times - BEGINS_S, times - BEGINS_S - lasts_s
    phase = math.pi * np.clip(before / lasts_s, 0.0, 1.0)
    speed = np.where(phase < math.pi / 2, CAME, LEFT)
    metres = np.select(
        [before < 0, after > 0],
        [CAME * before + GRAVITY * before**2 / 2, -LEFT * after + GRAVITY * after**2 / 2],
        speed * lasts_s / math.pi * np.sin(phase),
    )
    rows = 250.0 + SCALE * metres
    places = np.stack([rows, 100.0 + 0.1 * SCALE * times], axis=1)
    places += np.random.default_rng(2).normal(0.0, SIGMA_PX, places.shape)
    observed = Observed(np.arange(180), times, places, np.full((180, 2), SIGMA_PX))
    # As a search finds them, by frames next to the contact and in it.
    start = Start(
        np.array([BEGINS_S + lasts_s / 2]),
        np.array([[250.0, 100.0]]),
        SCALE * np.array([[0.85 * CAME, 0.1]]),
        SCALE * np.array([[-0.85 * LEFT, 0.1]]),
    )
    ball = Ball(DIAMETER, density=1000.0, air_density=1e-3)
    known = Known(ball, View(400, 200, 1 / RATE, 0.0, focal_px=(5000.0, 10.0)), RADIUS_PX)
    flights = fit_flights(observed, start, known)
    assert flights is not None
    came, left = flights.contacts[0, [1, 3]] / flights.scale_px_per_m
    assert came == pytest.approx(CAME, rel=0.01)
    assert left == pytest.approx(LEFT, rel=0.01)
    e, sigma = flights.coefficient(0)
    assert e == pytest.approx(LEFT / CAME, abs=4 * sigma)
    assert sigma < 0.02
