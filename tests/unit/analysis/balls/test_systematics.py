"""What radius and light of a ball do to all places of its film alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.balls.discs.disc import Disc
from analysis.balls.flight.fit import fit_flights
from analysis.balls.seen.looks import Looks
from analysis.balls.seen.placing import Placed
from analysis.balls.seen.windows import Motion
from analysis.balls.systematics import RimsOff, rims_off, shifts
from tests.unit.analysis.balls.parabolas import known, parabolas, start

RADIUS = 12.0


def looks(centres: Floats, radius_sigma_px: float = 0.2) -> Looks:
    seen = tuple(
        (frame, Disc(row, column, RADIUS, 0.1, 0.1, 0.1, 0.9, -20.0))
        for frame, (row, column) in enumerate(centres.tolist())
    )
    one = np.ones((1, 1))
    return Looks(RADIUS, radius_sigma_px, np.ones((6, 1)), one, one[0], seen)


def film(shift: tuple[float, float], scatter: float) -> tuple[Looks, Motion]:
    """Return a ball that falls as its rims show it, and places that lie off and scatter."""
    rng = np.random.default_rng(5)
    rims = np.column_stack([np.linspace(50.0, 300.0, 15), np.linspace(90.0, 95.0, 15)])
    places = rims - shift + scatter * rng.standard_normal(rims.shape)
    return looks(rims), Motion(np.arange(15), places, np.zeros_like(places))


def test_rims_that_lie_further_off_than_they_scatter_show_where_a_ball_is() -> None:
    off = rims_off(*film((-2.1, -1.2), 0.45))
    assert off is not None
    assert np.all(np.abs(off.shift - (-2.1, -1.2)) < 0.6)
    assert np.all(off.sigma > 0.2)


def test_rims_that_scatter_as_far_as_they_lie_off_show_nothing() -> None:
    assert rims_off(*film((-0.4, 0.3), 0.45)) is None


def test_first_places_a_third_of_the_radius_towards_the_light_are_brought_to_the_rims() -> None:
    assert rims_off(*film((3.6, 2.0), 0.1)) is not None


def test_discs_that_lie_more_than_half_of_the_radius_off_are_no_rims_of_the_ball() -> None:
    assert rims_off(*film((5.6, 3.2), 0.1)) is None


def test_places_at_the_rims_owe_little_to_a_radius_that_moves_them_all_alike() -> None:
    seen = parabolas(np.random.default_rng(2))
    # Half of the ball is dark: a radius 1.7 % larger moves all places 0.2 px down.
    leaning = replace(seen, leans=np.full(seen.places.shape, (12.0, 0.0)))
    flights = fit_flights(leaning, start(), known())
    assert flights is not None
    nothing = np.zeros(len(seen.frames))
    placed = Placed(seen.frames, seen.places, seen.sigmas, nothing, nothing, nothing)
    ball = looks(seen.places[:9])
    at_rims = RimsOff(np.zeros(2), np.array([0.03, 0.03]))
    free = shifts(ball, (placed, placed, placed), flights, None)
    held = shifts(ball, (placed, placed, placed), flights, at_rims)
    assert free[0, :, 0] == pytest.approx(0.2)
    assert np.all(held[0, :, 0] < 0.1)
    assert held[2] == pytest.approx(0.03)
