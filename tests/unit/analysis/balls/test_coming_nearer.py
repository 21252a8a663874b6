"""A ball that comes nearer far faster than it crosses the picture, projected point by point."""

from __future__ import annotations

import math

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Flights, Observed, Start
from analysis.balls.flight.known import Ball, Known, View

FOCAL, LOOK, AWAY_M, ABOVE_M = 1700.0, 0.2, 1.8, 0.45
NEARER, ACROSS = 0.4, 0.03
"""Speeds along the floor, m/s."""
LASTS = np.array([0.6, 0.42, 0.3, 0.21])
LOW, HIGH = np.append(LASTS, 0.15), 0.6 * 0.8 ** np.arange(5)
"""From bounce to bounce, s; the first is a fall of half of it."""
G, RATE, NOISE_PX, SIZE_NOISE, RADIUS = 9.80665, 60.0, 0.02, 4e-3, 18.0
HEIGHT, WIDTH = 480, 270


def seen_from_above(
    seed: int, lasts: Floats = LASTS, speed: float = ACROSS
) -> tuple[Observed, Start, float]:
    """Return places and sizes, a first guess of all bounces, and px/m at the first of them."""
    begun = np.cumsum(np.concatenate([[-0.5 * lasts[0]], lasts])) - 0.5 * lasts[0]

    def ahead_and_places(times: Floats) -> tuple[Floats, Floats]:
        flight = np.clip(np.searchsorted(begun, times, side="right") - 1, 0, len(lasts) - 1)
        gone = times - begun[flight]
        up = 0.5 * G * gone * (lasts[flight] - gone) - ABOVE_M
        off = AWAY_M - NEARER * times
        ahead = math.cos(LOOK) * off - math.sin(LOOK) * up
        over = math.sin(LOOK) * off + math.cos(LOOK) * up
        across = FOCAL * speed * times / ahead
        return ahead, np.stack([0.5 * HEIGHT - FOCAL * over / ahead, 0.5 * WIDTH + across], axis=1)

    bounces = begun[1:-1]
    before, after = (
        (ahead_and_places(bounces + side * 2e-3)[1] - ahead_and_places(bounces + side * 1e-3)[1])
        / (side * 1e-3)
        for side in (-1, 1)
    )
    times = np.arange(-0.25, begun[-1] - 0.03, 1 / RATE)
    ahead, places = ahead_and_places(times)
    near, at = ahead_and_places(bounces)
    rng = np.random.default_rng(seed)
    sizes = near[0] / ahead - 1.0 + SIZE_NOISE * rng.standard_normal(len(times))
    observed = Observed(
        np.arange(len(times)),
        times,
        places + NOISE_PX * rng.standard_normal(places.shape),
        np.full(places.shape, NOISE_PX),
        np.zeros(places.shape),
        np.stack([sizes, np.full(len(sizes), SIZE_NOISE)], axis=1),
    )
    start = Start(bounces + 2e-3, at, before, after)
    return observed, start, FOCAL / float(near[0])


def fitted(observed: Observed, start: Start, scale: float) -> Flights:
    ball = Ball(2 * RADIUS / scale, density=7800.0, air_density=1e-4)
    known = Known(ball, View(HEIGHT, WIDTH, 1 / RATE, 0.0), RADIUS)
    flights = fit_flights(observed, start, known)
    assert flights is not None
    return flights


@pytest.mark.parametrize("seed", range(6))
def test_a_ball_that_comes_nearer_keeps_its_bounces_and_their_e(seed: int) -> None:
    observed, start, scale = seen_from_above(seed)
    flights = fitted(observed, start, scale)
    truth = LASTS[1:] / LASTS[:-1]
    assert flights.bounces == len(truth)
    for bounce, e in enumerate(truth.tolist()):
        slope = flights.slopes_of_e(bounce)
        sigma = math.sqrt(slope @ flights.whole_covariance @ slope)
        found = flights.contacts[bounce, 3] / flights.contacts[bounce, 1]
        assert abs(found - e) < 4.0 * sigma
        assert sigma < 0.01
    rate_sigma = math.sqrt(flights.covariance[path.DEPTH, path.DEPTH])
    assert abs(flights.values[path.DEPTH] * scale * AWAY_M / FOCAL + NEARER / AWAY_M) < max(
        0.03, 4.0 * rate_sigma
    )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("lasts", [LOW, HIGH], ids=["low", "high"])
def test_bounces_that_sink_as_a_ball_comes_nearer_do_not_make_its_floor_lean(
    lasts: Floats, seed: int
) -> None:
    """A lean of half a radian explains them too, and v_n would be a sixth too small."""
    across = 0.1 if lasts is HIGH else ACROSS
    observed, start, scale = seen_from_above(seed, lasts, across)
    flights = fitted(observed, start, scale)
    assert not flights.leans
    assert flights.bounces == len(lasts) - 1
    # A fall from rest is half of the flight that follows a bounce with e of 1.
    arrives = flights.contacts[0, 1] / flights.scale_px_per_m
    assert arrives == pytest.approx(0.5 * G * lasts[0], rel=0.02)
