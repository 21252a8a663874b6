"""Places of a ball that bounces in a vacuum: pieces of parabolas, and a first guess of them."""

from __future__ import annotations

import numpy as np

from analysis.balls.flight.flights import Observed, Start
from analysis.balls.flight.known import Ball, Known, View

SCALE, FALL = 1000.0, 9806.65
PLATE, RATE = 400.0, 240.0
BOUNCES = [(0.3, 2.4, 1.9), (0.3 + 2 * 1.9 / 9.80665, 1.9, 1.45)]
NOISE = 0.02
Law = list[tuple[float, float, float]]
"""Of each bounce time, speed towards the plate and away, m/s."""


def parabolas(
    rng: np.random.Generator, law: Law = BOUNCES, lasts_s: float = 0.95, noise: float = NOISE
) -> Observed:
    """Places of a ball in a vacuum: pieces of parabolas that meet the plate."""
    times = np.arange(0, lasts_s, 1 / RATE)
    rows = np.empty(len(times))
    for k, t in enumerate(times):
        past = [b for b in law if b[0] <= t]
        if past:
            begun, _, up = past[-1]
            rows[k] = PLATE - SCALE * up * (t - begun) + 0.5 * FALL * (t - begun) ** 2
        else:
            begun, down, _ = law[0]
            rows[k] = PLATE + SCALE * down * (t - begun) + 0.5 * FALL * (t - begun) ** 2
    places = np.stack([rows, 100 + 20 * times], axis=1)
    places += noise * rng.standard_normal(places.shape)
    return Observed(np.arange(len(times)), times, places, np.full(places.shape, NOISE))


def start(law: Law = BOUNCES) -> Start:
    """A first guess that is off by a few per cent, as sightings give it."""
    times = np.array([b[0] for b in law]) + 0.001
    down = np.array([[SCALE * b[1] * 1.02, 20.0] for b in law])
    up = np.array([[-SCALE * b[2] * 0.98, 20.0] for b in law])
    places = np.array([[PLATE + 2, 106.0], [PLATE - 1, 114.0], [PLATE, 120.0]])
    return Start(times, places[: len(law)], down, up)


def known(diameter_m: float = 0.04, exposure_s: float = 0.0) -> Known:
    ball = Ball(diameter_m, density=7800.0, air_density=0.0001)
    return Known(ball, View(480, 200, 1 / RATE, exposure_s), radius_px=20.0)
