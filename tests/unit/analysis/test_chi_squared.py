"""The chi-squared distribution, held against sums of squares that are drawn."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.chi_squared import chance_of_more, limit, median
from analysis.model.verdict.forward import ranks_of


def test_the_chance_of_a_chi_squared_is_the_share_of_sums_of_squares_above_it() -> None:
    drawn = (np.random.default_rng(3).standard_normal((40_000, 12)) ** 2).sum(axis=1)
    levels = np.array([6.0, 12.0, 20.0, 25.0])
    shares = (drawn[:, None] > levels).mean(axis=0)
    assert np.all(abs(chance_of_more(levels, 12) - shares) < 4 * np.sqrt(shares / 40_000))


def test_without_a_degree_of_freedom_nothing_is_rare() -> None:
    assert list(chance_of_more([5.0, 1e3], [0, 3]) == 1.0) == [True, False]


def test_the_limit_is_the_chi_squared_of_that_chance() -> None:
    """5 % and 1 % of the tables: K. Pearson, Phil. Mag. 50, 157 (1900)."""
    assert limit([0.05, 0.01], [1, 10]) == pytest.approx([3.8415, 23.209], rel=1e-4)
    assert median(2) == pytest.approx(2 * np.log(2))


def test_equal_numbers_share_their_mean_rank() -> None:
    assert list(ranks_of(np.array([0.3, 0.1, 0.3, 0.2, 0.3]))) == [4, 1, 4, 2, 4]
