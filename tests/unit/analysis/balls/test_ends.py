"""Flights go on to bounces to which a camera that looks down sees them fall ever less fast."""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.balls.seen.arcs import Arc, Chain, Sightings
from analysis.balls.seen.ends import lengthened

G, RATE, RADIUS, SHAPE = 9.80665, 30.0, 60.0, (1920, 1080)
FOCAL, LOOK, AWAY_M = 1900.0, 0.3, 1.05
DROP_M, LEAVES = 0.95, 0.58
"""Height of the fall, and speed after the bounce over that before."""
BOUNCE_S = math.sqrt(2.0 * DROP_M / G)
FALL = np.array([0.93 * G * FOCAL / AWAY_M, 0.0])


def rows(times: Floats) -> Floats:
    """Rows that a pinhole sees which looks down by an angle at a ball that falls and bounces."""
    came = math.sqrt(2.0 * G * DROP_M)
    since = times - BOUNCE_S
    up = np.where(since < 0.0, -came * since, LEAVES * came * since) - 0.5 * G * since**2
    below = 0.5 - up
    ahead = math.cos(LOOK) * AWAY_M + math.sin(LOOK) * below
    over = math.cos(LOOK) * below - math.sin(LOOK) * AWAY_M
    return np.asarray(1450.0 + FOCAL * over / ahead)


def film(times: Floats) -> Sightings:
    """One sighting of the ball in each frame, and one of something that stands still."""
    still = [1500.0, 200.0, 0.5]
    places = [np.array([[row, 400.0, 1.0], still]) for row in rows(times).tolist()]
    return Sightings(times, places, SHAPE)


def piece(seen: Sightings, first: int, last: int) -> Arc:
    frames = np.arange(first, last)
    places = np.array([seen.places[k][0, :2] for k in frames])
    return Arc(frames, seen.times_s[frames], places, float(len(frames)))


def chain(seen: Sightings, before: int, after: int) -> Chain:
    """A flight that was followed up to one frame, and one from another on."""
    arcs = piece(seen, 1, before), piece(seen, after, len(seen.times_s))
    return Chain(arcs, np.array([BOUNCE_S]), np.array([[1600.0, 400.0]]))


def test_a_flight_goes_on_to_its_bounce_as_it_falls_beside_it() -> None:
    times = np.arange(26) / RATE
    seen = film(times)
    bounce = int(BOUNCE_S * RATE)
    before, after = lengthened(chain(seen, bounce - 2, bounce + 3), seen, RADIUS, FALL).arcs
    assert before.frames.tolist() == list(range(1, bounce + 1))
    assert after.frames.tolist() == list(range(bounce + 3, 26))
    assert np.array_equal(before.places[:, 0], rows(times)[before.frames])


def test_a_flight_does_not_go_on_to_what_lies_off_its_way() -> None:
    seen = film(np.arange(26) / RATE)
    bounce = int(BOUNCE_S * RATE)
    seen.places[bounce - 1][0, 0] += RADIUS
    short = chain(seen, bounce - 1, bounce + 3)
    assert lengthened(short, seen, RADIUS, FALL).arcs[0].frames[-1] == bounce - 2


def test_a_flight_before_a_level_camera_ends_where_the_search_ended_it() -> None:
    times = np.arange(26) / RATE
    seen = film(times)
    bounce = int(BOUNCE_S * RATE)
    for frame, row in enumerate((100.0 + 0.5 * FALL[0] * times**2).tolist()):
        seen.places[frame][0, 0] = row
    short = chain(seen, bounce - 2, bounce + 3)
    assert lengthened(short, seen, RADIUS, FALL).arcs[0].frames[-1] == bounce - 3
