import numpy as np
import pytest
from scipy.stats import norm

from analysis.model.design.probability import LEVEL, named_over_none, named_over_rival

DRAWS = 200_000


def share_named(strength: float, apart: float) -> float:
    """Count how often the larger of two Gaussian scores, squared, is the right one's."""
    d, rho = np.sqrt(strength), np.sqrt(1 - apart / strength)
    first, second = np.random.default_rng(3).standard_normal((2, DRAWS))
    right = d + first
    wrong = rho * d + rho * first + np.sqrt(1 - rho**2) * second
    return float((right**2 > wrong**2).mean())


@pytest.mark.parametrize(("strength", "apart"), [(9.0, 8.9), (16.0, 6.0), (400.0, 4.0)])
def test_the_probability_is_the_share_of_drawn_scores(strength: float, apart: float) -> None:
    assert named_over_rival(strength, apart) == pytest.approx(
        share_named(strength, apart), abs=0.006
    )


@pytest.mark.parametrize("apart", [4.0, 12.0])
@pytest.mark.parametrize("more", [-2, -1, 1, 2])
def test_a_parameter_more_gains_by_noise_and_pays_for_it(apart: float, more: int) -> None:
    rng = np.random.default_rng(4)
    ahead = apart + 2 * np.sqrt(apart) * rng.standard_normal(DRAWS)
    ahead += np.sign(more) * rng.chisquare(abs(more), DRAWS) - more * np.log(20)
    expected = float((ahead > 0).mean())
    assert named_over_rival(400.0, apart, more=more, shots=20) == pytest.approx(expected, abs=0.02)


def test_effects_that_nothing_sets_apart_are_named_by_chance() -> None:
    assert named_over_rival(100.0, 0.0) == pytest.approx(0.5)


def test_near_aliases_need_four_times_the_square_of_the_quantile() -> None:
    apart = (2 * norm.ppf(0.9)) ** 2
    assert named_over_rival(1e6, apart) == pytest.approx(0.9, abs=1e-4)


def test_an_effect_of_no_size_is_named_as_often_as_chance_allows() -> None:
    assert named_over_none(0.0, 1) == pytest.approx(LEVEL, rel=1e-6)


def test_one_parameter_is_named_when_its_score_passes_either_end() -> None:
    z = norm.isf(LEVEL / 2)
    expected = norm.sf(z - 4.0) + norm.cdf(-z - 4.0)
    assert named_over_none(16.0, 1) == pytest.approx(expected, rel=1e-6)
