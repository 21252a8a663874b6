"""What a hand carries through a film is said to be carried, not to fly, roll or fall slowly."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.balls import analysis
from analysis.balls.falling import flights_of, other_fall
from analysis.balls.films.film import HeldFilm
from analysis.balls.flight.known import Ball
from analysis.balls.looking import Looked
from analysis.balls.measuring import measure_ball
from analysis.balls.searching import cause_of
from analysis.balls.seen.arcs import Sightings
from analysis.errors import ShotRefusedError
from tests.unit.analysis.balls.test_joining import BALL, RADIUS
from tests.unit.cli.falling_ball import DIAMETER_MM, bouncing, picture
from tests.unit.cli.falling_ball import RATE as FAST

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


@pytest.mark.parametrize(
    ("off_radii", "every", "refused"), [(0.2, 2, False), (0.5, 1, False), (0.5, 2, True)]
)
def test_few_places_that_lie_far_off_all_flights_give_no_e(
    off_radii: float, every: int, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A person who juggles, whose balls are taken for one that bounces and is seen now and then."""
    film = HeldFilm(Path("film"), np.array([picture(row) for row in bouncing(80)]))
    given = np.arange(80) / FAST, Ball(1e-3 * DIAMETER_MM), 0.0
    measured = measure_ball(Looked(film), *given)
    flights = measured.flights
    assert flights is not None
    off = off_radii * measured.looks.radius_px * (-1.0) ** (np.arange(len(flights.arcs)) // every)
    few = np.arange(0, len(flights.arcs), every)
    far = replace(
        flights,
        observed=flights.observed.of(few),
        residuals=(flights.residuals + off[:, None])[few],
        used=flights.used[few],
        arcs=flights.arcs[few],
    )
    monkeypatch.setattr(analysis, "measure_ball", lambda *_: replace(measured, flights=far))
    monkeypatch.setattr(analysis, "in_doubt", lambda _: False)
    monkeypatch.setattr(analysis, "remarks", lambda _: ())
    if refused:
        with pytest.raises(ShotRefusedError, match="its radius off free flights that bounce"):
            analysis.analyse_held(film, *given)
    else:
        assert analysis.analyse_held(film, *given).measured.bounces == 1
