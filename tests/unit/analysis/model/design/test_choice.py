"""The slope of a straight line: its best design is known, half of the shots at either end."""

import numpy as np
import pytest

from analysis.model.design.choice import chosen, exchanged, fewest_even
from analysis.model.design.sharpen import Sharpness

PLACES = np.linspace(-1.0, 1.0, 9)
ONE_SHOT = np.array([[[1.0, x], [x, x**2]] for x in PLACES])
SLOPE = Sharpness(known=1e-6 * np.eye(2), shown=ONE_SHOT, place=1)


@pytest.mark.parametrize("shots", [4, 16, 100])
def test_the_shots_for_a_slope_lie_at_both_ends(shots: int) -> None:
    target = 1.001 / np.sqrt(shots)
    counts = chosen(SLOPE, lambda n: SLOPE.sigma(n) <= target, 500)
    assert counts.sum() == shots
    assert counts[0] == counts[-1] == shots / 2


def test_shots_that_are_badly_placed_are_moved() -> None:
    middle = np.zeros(9)
    middle[[3, 4, 5]] = 4
    moved = exchanged(SLOPE, middle)
    assert moved.sum() == 12
    assert moved[0] == moved[-1] == 6


def test_what_is_known_already_costs_no_shot() -> None:
    assert chosen(SLOPE, lambda n: True, 500).sum() == 0


def test_a_design_ends_at_the_most_that_may_be_fired() -> None:
    assert chosen(SLOPE, lambda n: False, 7).sum() == 7


def test_a_start_with_too_many_shots_is_thinned() -> None:
    start = np.full(9, 3.0)
    counts = chosen(SLOPE, lambda n: SLOPE.sigma(n) <= 0.5, 500, start)
    assert counts.sum() == 5 or counts.sum() == 4
    assert SLOPE.sigma(counts) <= 0.5


def test_an_even_design_is_as_large_as_its_mean_information_says() -> None:
    target = 0.1
    expected = int(np.ceil(1 / target**2 / (PLACES**2).mean()))
    found = fewest_even(9, lambda n: SLOPE.sigma(n) <= target, 5000)
    assert found is not None
    assert abs(found - expected) <= 1


def test_an_even_design_beyond_the_most_is_not_named() -> None:
    assert fewest_even(9, lambda n: SLOPE.sigma(n) <= 1e-3, 5000) is None
