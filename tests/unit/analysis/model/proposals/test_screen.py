"""The threshold of many correlated scores holds its error rate."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from analysis.model.proposals.screen import Screen, largest_by_chance

LEVEL = 0.05


def test_independent_scores_give_the_threshold_of_a_product_of_chances() -> None:
    largest = np.sort(largest_by_chance(np.eye(200), np.random.default_rng(1)))
    exact = norm.isf((1 - (1 - LEVEL) ** (1 / 200)) / 2)
    assert Screen((), np.zeros(0), largest).threshold(LEVEL) == pytest.approx(exact, abs=0.08)


def test_copies_of_one_column_cost_nothing() -> None:
    largest = np.sort(largest_by_chance(np.ones((50, 50)), np.random.default_rng(1)))
    expected = norm.isf(LEVEL / 2)
    assert Screen((), np.zeros(0), largest).threshold(LEVEL) == pytest.approx(expected, abs=0.12)


def test_a_chance_is_the_share_of_draws_beyond_and_falls_on_as_a_normal_does() -> None:
    largest = np.sort(largest_by_chance(np.eye(100), np.random.default_rng(2)))
    screen = Screen((), np.zeros(0), largest)
    assert screen.p_familywise(screen.threshold(0.3)) == pytest.approx(0.3, abs=0.01)
    chances = [screen.p_familywise(z) for z in (3.0, 4.0, 5.0, 6.0)]
    assert chances == sorted(chances, reverse=True)
    assert chances[-1] == pytest.approx(100 * 2 * norm.sf(6.0), rel=0.6)


def test_without_columns_nothing_passes() -> None:
    screen = Screen((), np.zeros(0), np.zeros(0))
    assert screen.threshold(LEVEL) == np.inf
    assert screen.p_familywise(9.0) == 1.0
