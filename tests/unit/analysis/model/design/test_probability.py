import pytest
from scipy.stats import norm

from analysis.model.design.duel import LEVEL, named_over_none


def test_an_effect_of_no_size_is_named_as_often_as_chance_allows() -> None:
    assert named_over_none(0.0, 1) == pytest.approx(LEVEL, rel=1e-6)


def test_one_parameter_is_named_when_its_score_passes_either_end() -> None:
    z = norm.isf(LEVEL / 2)
    expected = norm.sf(z - 4.0) + norm.cdf(-z - 4.0)
    assert named_over_none(16.0, 1) == pytest.approx(expected, rel=1e-6)
