"""Films in which no ball flies: what was seen tells whether their pictures are to be turned."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from analysis.balls import analysis
from analysis.balls.analysis import analyse_held
from analysis.balls.carried import CarriedError
from analysis.balls.falling import turned
from analysis.balls.films.film import Film, HeldFilm
from analysis.balls.films.part import Cut, PartOfFilm
from analysis.balls.flight.known import Ball
from analysis.balls.looking import Looked
from analysis.balls.measuring import MeasuredBall, measure_ball
from analysis.balls.seen.arcs import Sightings
from tests.unit.cli.falling_ball import DIAMETER_MM, FALL, RATE, bouncing, picture

BALL = Ball(1e-3 * DIAMETER_MM)


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> list[Film]:
    """Return films that are measured, each once for each time."""
    films: list[Film] = []

    def kept(looked: Looked, *known: object) -> MeasuredBall:
        films.append(looked.film)
        return measure_ball(looked, *known)  # type: ignore[arg-type]

    monkeypatch.setattr(analysis, "measure_ball", kept)
    return films


def test_a_film_of_a_ball_that_rolls_is_measured_once(measured: list[Film]) -> None:
    shown = np.array([picture(200.0, 15.0 + 1.5 * k) for k in range(60)])
    with pytest.raises(CarriedError, match="rolls or slides"):
        analyse_held(HeldFilm(Path("film"), shown), np.arange(60) / RATE, BALL, 0.0)
    assert len(measured) == 1


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_a_film_in_which_a_ball_falls_elsewhere_is_measured_turned(turns: int) -> None:
    shown = np.array([np.rot90(picture(row), -turns) for row in bouncing(80)])
    found = analyse_held(HeldFilm(Path("film"), shown), np.arange(80) / RATE, BALL, 0.0)
    assert found.measured.bounces == 1
    assert found.measured.flights is not None
    assert found.measured.flights.coefficient(0)[0] == pytest.approx(0.8, abs=0.01)


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_places_turn_with_their_pictures(turns: int) -> None:
    marked = np.zeros((1, 24, 16), np.uint8)
    marked[0, 5, 11] = 255
    seen = turned(Sightings(np.zeros(1), [np.array([[5.0, 11.0, 1.0]])], (24, 16)), turns)
    (shown,) = PartOfFilm(HeldFilm(Path("film"), marked), Cut(), turns).pictures()
    assert seen.shape == shown.shape[:2]
    (place,) = seen.places
    assert shown[int(place[0, 0]), int(place[0, 1]), 0] == 255


def test_a_ball_that_is_pushed_and_rolls_flies_in_no_film_that_lies_on_its_side() -> None:
    """Along the push it moves as in a fall, for some frames."""
    pushed, rolls = np.arange(16) / RATE, np.arange(1, 50) / RATE
    along = 25.0 + 0.5 * FALL * pushed**2
    speed = FALL * pushed[-1]
    columns = np.concatenate([np.full(12, 25.0), along, along[-1] + speed * rolls])
    columns = columns[columns < 95.0]
    shown = np.array([picture(200.0, column) for column in columns])
    with pytest.raises(CarriedError, match="rolls or slides"):
        analyse_held(HeldFilm(Path("film"), shown), np.arange(len(shown)) / RATE, BALL, 0.0)


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 3])
def test_hollows_as_shallow_as_the_scatter_of_places_put_no_film_upside_down(seed: int) -> None:
    """A ball rests, then rolls through two hollows of 2 px, which upside down would be hops.

    Its places scatter by a pixel, so that how they bend gives gravity to a fifth at best.
    """
    rng, hop = np.random.default_rng(seed), np.arange(15)
    fallen = 0.5 * FALL / RATE**2 * hop * (15 - hop)
    rows = 200.0 + np.concatenate([np.zeros(40), fallen, 0.9 * fallen, np.zeros(4)])
    rows[40:] += rng.standard_normal(74)[40:]
    columns = np.concatenate([np.full(40, 20.0), 20.0 + 2.3 * np.arange(34)])
    shown = [picture(round(row, 2), column) for row, column in zip(rows, columns, strict=True)]
    times = np.arange(len(shown)) / RATE
    found = analyse_held(HeldFilm(Path("film"), np.array(shown)), times, BALL, 0.0)
    assert found.measured.bounces == 0
    assert not any("upside down" in note for note in found.notes)
