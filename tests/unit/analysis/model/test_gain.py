"""Gains on shots left out: those that all shots share, and those of a few."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from analysis.model.verdict.forward import is_shared, signed_rank


def test_gains_without_a_cause_have_a_unit_normal_sum_of_signed_ranks() -> None:
    rng = np.random.default_rng(0)
    sums = [signed_rank(rng.normal(size=80)) for _ in range(2000)]
    assert np.mean(sums) == pytest.approx(0.0, abs=0.1)
    assert np.std(sums) == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("d", [4.0, 6.0, 10.0, 30.0])
def test_a_real_effect_of_any_strength_is_the_campaigns(d: float) -> None:
    rng, shots = np.random.default_rng(1), 60
    share, accepted = d / np.sqrt(shots), 0
    for _ in range(400):
        noise = rng.normal(size=shots)
        accepted += is_shared(share**2 + 2 * share * noise, d**2)
    assert accepted / 400 > norm.cdf(2.0) - 0.04


def test_what_two_shots_gain_is_theirs_alone() -> None:
    rng = np.random.default_rng(2)
    gains = rng.normal(0.0, 0.3, 60)
    gains[[7, 31]] = 80.0
    assert not is_shared(gains, 160.0)


def test_shots_without_a_gain_say_nothing() -> None:
    assert signed_rank(np.zeros(12)) == 0.0
    assert not is_shared(np.zeros(12), 20.0)
