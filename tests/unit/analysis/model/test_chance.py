"""The chance of a fall of chi-squared when nothing is missing."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from analysis.model.rank.score_test import chance_of_falls


def test_a_fall_of_one_sign_has_half_the_chance_of_a_normal_deviate() -> None:
    falls = np.array([1.0, 4.0, 16.0])
    wanted = norm.sf([1.0, 2.0, 4.0])
    assert chance_of_falls(falls, 1, one_sided=True) == pytest.approx(wanted)
    assert chance_of_falls(falls, 1, one_sided=False) == pytest.approx(2 * wanted)


def test_what_makes_a_fit_worse_is_sheer_chance() -> None:
    # A law that does not contain the other may fit worse than it.
    assert chance_of_falls(np.array([-5.0]), 1, one_sided=True) == [1.0]
