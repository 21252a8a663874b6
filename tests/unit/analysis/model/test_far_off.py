"""A chi-squared is far off by its own distribution, whatever its degrees of freedom."""

from __future__ import annotations

from dataclasses import replace

import pytest

from analysis.chi_squared import chance_of_more
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.structure.far_off import is_far_off
from tests.unit.analysis.model.hard_spheres import campaign


@pytest.fixture(scope="module")
def fit() -> Fit:
    return fit_campaign(campaign(20, 5))


def test_a_campaign_at_its_noise_is_not_far_off(fit: Fit) -> None:
    assert fit.p_chi2 > 0.01
    assert not is_far_off(fit)


def test_a_tenth_more_in_every_shot_of_many_numbers_is_far_off(fit: Fit) -> None:
    """Of 5000 degrees of freedom a tenth is five standard deviations."""
    assert fit.freedom > 5000
    assert is_far_off(replace(fit, chi2=1.1 * fit.chi2, shot_chi2=1.1 * fit.shot_chi2))


def test_a_quarter_more_of_few_numbers_is_not() -> None:
    """As in eight shots of a table, whose chi-squared of 1.25 chance exceeds once in twenty."""
    assert 0.03 < chance_of_more(1.25 * 93, 93) < 0.08


def test_what_two_shots_alone_leave_is_theirs(fit: Fit) -> None:
    own = fit.shot_chi2.copy()
    own[[3, 11]] *= 4.0
    two = replace(fit, chi2=fit.chi2 + float((own - fit.shot_chi2).sum()), shot_chi2=own)
    assert two.p_chi2 < 1e-6
    assert not is_far_off(two)


def test_of_fewer_than_five_shots_none_is_far_off() -> None:
    small = fit_campaign(campaign(4, 6))
    assert not is_far_off(replace(small, chi2=9 * small.chi2, shot_chi2=9 * small.shot_chi2))
