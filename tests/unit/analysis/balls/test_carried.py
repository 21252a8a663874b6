"""What a hand carries through a film is said to be carried, not to fly, roll or fall slowly."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.balls.falling import flights_of, other_fall
from analysis.balls.flight.known import Ball
from analysis.balls.searching import cause_of
from analysis.balls.seen.arcs import Sightings
from tests.unit.analysis.balls.test_joining import BALL, RADIUS

RATE = 30.0
STATED = np.array([Ball(0.066).gravity * 2 * RADIUS / 0.066, 0.0])


def to_and_fro(radii: float) -> Floats:
    """A hand goes to the right in 1.5 s, turns round, and goes back in 3 s while it rises."""
    out, turn, back = np.arange(45) / 45, np.arange(27) / 27, np.arange(91) / 91
    rows = [0.0 * out, -0.4 * turn**2, -0.4 - 0.8 * (1.0 - (1.0 - back) ** 2)]
    columns = [4.4 * out**0.9, 4.4 + 0.5 * np.sin(np.pi * turn), 4.4 - 3.7 * back**0.95]
    way = np.stack([np.concatenate(rows), np.concatenate(columns)], axis=1)
    return np.asarray(radii * way + [140.0, 60.0])


def seen_at(places: Floats) -> Sightings:
    scatter = np.random.default_rng(1).normal(0.0, 0.2, places.shape)
    seen = [np.array([[*each, 1.0]]) for each in places + scatter]
    return Sightings(np.arange(len(seen)) / RATE, seen, (400, 400))


def test_a_hand_that_moves_a_ball_to_and_fro_shows_no_fall_in_slow_motion() -> None:
    seen = seen_at(to_and_fro(RADIUS))
    assert other_fall(seen, BALL, STATED, flights_of(seen, BALL, STATED)) is None


@pytest.mark.parametrize(("rises", "said"), [(0.0, "rolls or slides"), (60.0, "held or carried")])
def test_what_leaves_the_line_between_its_ends_is_carried(rises: float, said: str) -> None:
    gone = np.linspace(0.0, 1.0, 120)
    places = np.stack([200.0 - rises * np.sin(np.pi * gone), 60.0 + 240.0 * gone], axis=1)
    assert said in cause_of(seen_at(places), BALL, STATED)
