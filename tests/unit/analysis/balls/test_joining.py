"""Pieces of one flight become one; flights on the two sides of a bounce stay two."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.balls.seen.arcs import Arc, joined

Floats = NDArray[np.float64]

RATE, FALL, RADIUS, SHAPE = 200.0, np.array([2800.0, 0.0]), 14.0, (400, 200)


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


def test_flights_before_and_after_a_bounce_stay_apart() -> None:
    before = fallen(100.0, np.arange(40.0))
    after = before[-1] - fallen(0.0, np.arange(1.0, 30.0))[::-1]
    after += before[-1] - after[0]
    assert len(joined([arc(0, before), arc(40, after)], RADIUS, FALL, SHAPE)) == 2


def test_short_hops_on_a_plate_stay_apart() -> None:
    hop = 300.0 - fallen(0.0, np.abs(np.arange(-5.0, 6.0)))
    hop = hop.min() + hop.max() - hop
    assert len(joined([arc(0, hop), arc(11, hop)], RADIUS, FALL, SHAPE)) == 2
