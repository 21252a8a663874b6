"""The regression finds the law that made the impacts, with errors as large as it errs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.collision.operator import WaltonLaw
from analysis.results.impacts import Impacts
from analysis.results.likelihood import likelihood, transition
from analysis.results.lines import Lines, TooFewShotsError, fit_lines
from tests.unit.analysis.results.measured import CORNER, LAW, LEVER, both_regimes, impacts

CAMPAIGNS = 60
TRUTH = dict(zip(("e", "mu", "beta0"), LAW, strict=True))


@pytest.fixture(scope="module")
def fitted() -> list[Lines]:
    found = []
    for seed in range(CAMPAIGNS):
        rng = np.random.default_rng(seed)
        found.append(fit_lines(impacts(rng, both_regimes(rng, 30))))
    return found


@pytest.mark.parametrize("name", TRUTH)
def test_errors_of_the_regression_are_as_large_as_it_errs(fitted: list[Lines], name: str) -> None:
    pulls = []
    for one in fitted:
        sigma = np.sqrt(one.covariance[one.fitted.index(name), one.fitted.index(name)])
        pulls.append((getattr(one.law, name) - TRUTH[name]) / sigma)
    assert np.mean(pulls) == pytest.approx(0, abs=4 / np.sqrt(CAMPAIGNS))
    assert np.std(pulls) == pytest.approx(1, abs=4 / np.sqrt(2 * CAMPAIGNS))


def test_chi_squared_counts_the_constraints_less_what_was_fitted(fitted: list[Lines]) -> None:
    mean = np.mean([one.chi2 / one.freedom for one in fitted])
    # A shot at the corner may lie on either line and takes the nearer: a little less than 1.
    assert mean == pytest.approx(1, abs=0.06)
    assert fitted[0].freedom == 2 * 30 - 3
    # Errors are believed unless the scatter contradicts them: by chance in one campaign of 100.
    assert sum(one.scatter > 1 for one in fitted) <= 4


def test_scatter_beyond_the_stated_errors_enlarges_those_of_the_result() -> None:
    rng = np.random.default_rng(5)
    honest = impacts(rng, both_regimes(rng, 40))
    small = replace(honest, covariance=honest.covariance / 9)
    one, other = fit_lines(honest), fit_lines(small)
    assert other.scatter == pytest.approx(3, rel=0.25)
    for name, quantity in one.parameters().items():
        assert other.parameters()[name].sigma == pytest.approx(quantity.sigma, rel=0.3)


def test_a_campaign_that_only_slides_has_no_rotational_restitution() -> None:
    rng = np.random.default_rng(1)
    found = fit_lines(impacts(rng, rng.uniform(0.5, 4, 20)))
    assert found.fitted == ("e", "mu")
    assert found.law.mu == pytest.approx(0.08, abs=0.003)
    assert (found.held.slides > 0.99).all()


def test_a_campaign_that_only_sticks_has_no_friction() -> None:
    rng = np.random.default_rng(2)
    found = fit_lines(impacts(rng, rng.uniform(0.02, 0.25, 20)))
    assert found.fitted == ("e", "beta0")
    assert found.law.beta0 == pytest.approx(0.69, abs=0.05)


@pytest.mark.long
def test_a_single_shot_does_not_make_a_regime_of_its_own_by_chance() -> None:
    seen = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        seen.append(fit_lines(impacts(rng, rng.uniform(0.5, 4, 12))).fitted)
    assert seen.count(("e", "mu")) == len(seen)


def test_glancing_shots_count_as_their_errors_let_them() -> None:
    """Ten glancing shots, with errors of v_s / |v_n| of their own size, change next to nothing."""
    rng = np.random.default_rng(8)
    plain = impacts(rng, both_regimes(rng, 40))
    glancing = impacts(rng, np.full(10, 80.0), approach=np.full(10, 0.05))
    whole = replace(
        plain,
        shots=np.arange(50),
        velocities=np.concatenate([plain.velocities, glancing.velocities]),
        covariance=np.concatenate([plain.covariance, glancing.covariance]),
    )
    before, after = fit_lines(plain), fit_lines(whole)
    for name, quantity in before.parameters().items():
        shift = abs(getattr(after.law, name) - quantity.value)
        assert shift < quantity.sigma, name
        assert after.parameters()[name].sigma < 1.01 * quantity.sigma


def test_shots_without_spins_still_tell_of_restitution() -> None:
    rng = np.random.default_rng(4)
    found = impacts(rng, both_regimes(rng, 20))
    found.velocities[:, [1, 3]] = np.nan
    lines = fit_lines(found)
    assert lines.fitted == ("e",)
    assert lines.law.e == pytest.approx(0.74, abs=0.005)
    assert np.isnan(lines.held.slides).all()


def test_far_from_the_corner_chi_squared_is_that_of_the_own_line() -> None:
    rng = np.random.default_rng(6)
    found = impacts(rng, np.array([0.05, 0.05, 3.0, 3.0]))
    held = likelihood(found, WaltonLaw(*LAW))
    np.testing.assert_allclose(held.chi2[:2], held.sticking.chi2[:2], rtol=1e-6)
    np.testing.assert_allclose(held.chi2[2:], held.sliding.chi2[2:], rtol=1e-6)
    np.testing.assert_allclose(held.slides, [0, 0, 1, 1], atol=1e-9)


def test_the_lines_meet_where_friction_is_just_enough_to_stick() -> None:
    assert transition(WaltonLaw(*LAW), LEVER) == pytest.approx(CORNER)


def test_no_impact_at_all_is_said() -> None:
    none = Impacts(np.zeros(0, dtype=np.intp), np.zeros((0, 4)), np.zeros((0, 4, 4)), LEVER)
    with pytest.raises(TooFewShotsError, match="no shot"):
        fit_lines(none)


def test_shots_at_one_setting_that_go_on_have_slid() -> None:
    rng = np.random.default_rng(9)
    found = fit_lines(impacts(rng, np.full(6, 2.0), approach=np.full(6, 2.0)))
    assert found.fitted == ("e", "mu")
    assert found.law.mu == pytest.approx(0.08, abs=0.005)


def test_shots_at_one_setting_that_are_reversed_may_have_done_either() -> None:
    rng = np.random.default_rng(9)
    found = fit_lines(impacts(rng, np.full(6, 0.15), approach=np.full(6, 2.0)))
    assert found.fitted == ("e",)
    assert np.isnan(found.held.slides).all()


def test_a_shot_with_a_slipped_marker_does_not_move_the_law_and_is_named() -> None:
    rng = np.random.default_rng(12)
    sound = impacts(rng, both_regimes(rng, 30))
    slipped = replace(sound, velocities=sound.velocities.copy())
    slipped.velocities[4, 3] += 3.0
    before, after = fit_lines(sound), fit_lines(slipped)
    assert list(np.flatnonzero(~after.used)) == [4]
    assert after.freedom == before.freedom - 2
    for name, quantity in before.parameters().items():
        assert abs(getattr(after.law, name) - quantity.value) < quantity.sigma


def test_many_shots_off_the_lines_are_physics_and_all_count() -> None:
    rng = np.random.default_rng(13)
    found = impacts(rng, both_regimes(rng, 30))
    found.velocities[:8, 3] += 3.0
    lines = fit_lines(found)
    assert lines.used.all()
    assert lines.scatter > 3


def test_head_on_shots_tell_restitution_alone() -> None:
    rng = np.random.default_rng(3)
    found = impacts(rng, np.zeros(8))
    found.velocities[:, [1, 3]] = 0.0
    lines = fit_lines(found)
    assert lines.fitted == ("e",)
    assert lines.law.e == pytest.approx(0.74, abs=0.01)


def test_a_head_on_shot_among_others_is_no_hindrance() -> None:
    rng = np.random.default_rng(3)
    found = impacts(rng, both_regimes(rng, 30))
    found.velocities[0, [1, 3]] = 0.0
    assert fit_lines(found).fitted == ("e", "mu", "beta0")
