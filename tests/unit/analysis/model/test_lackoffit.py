"""What is left has uniform p-values when nothing is missing, and shows in the right cell if not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.fitting.own_fit import own_states
from analysis.model.structure import lackoffit
from analysis.model.structure.alarm import alarms
from analysis.model.structure.lackoffit import Cell, lack_of_fit
from analysis.setup import NO_SLOW_ERRORS, SlowErrors
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

CAMPAIGNS = 8
ALARM = 0.01


def cells_of(data: PoseData) -> tuple[Cell, ...]:
    return lack_of_fit(data, fit_campaign(data))


@pytest.fixture(scope="module")
def quiet() -> tuple[Cell, ...]:
    return cells_of(campaign(30, 600))


def test_every_channel_is_held_against_everything_it_may_depend_on(
    quiet: tuple[Cell, ...],
) -> None:
    # 12 jumps against 8 covariates, 12 displacements against time, 3 x 3 against the field.
    assert len({(cell.channel, cell.covariate) for cell in quiet}) == 12 * 8 + 12 + 9
    assert all(1 <= cell.freedom <= 5 for cell in quiet if cell.p_value < 1)


@pytest.mark.long
def test_p_values_are_uniform_when_nothing_is_missing() -> None:
    each = [cells_of(campaign(30, 600 + seed)) for seed in range(CAMPAIGNS)]
    p_values = np.array([cell.p_value for cells in each for cell in cells])
    # Cells of a campaign share their residuals: bounds of three times a binomial's.
    for level in (0.05, 0.25, 0.5, 0.75):
        spread = np.sqrt(level * (1 - level) / len(p_values))
        assert (p_values < level).mean() == pytest.approx(level, abs=9 * spread)
    assert sum(cells[0].p_holm < ALARM for cells in each) <= 1


def test_holm_multiplies_the_smallest_p_by_the_number_of_cells(quiet: tuple[Cell, ...]) -> None:
    assert quiet[0].p_holm == pytest.approx(min(1.0, len(quiet) * quiet[0].p_value))
    assert [c.p_value for c in quiet] == sorted(c.p_value for c in quiet)
    assert [c.p_holm for c in quiet] == sorted(c.p_holm for c in quiet)


def test_a_force_between_the_spheres_shows_in_their_distance_against_time() -> None:
    first = cells_of(campaign(40, 61, hidden=Hidden(pull=30.0)))[0]
    assert (first.channel, first.covariate) == ("relative position n", "time")
    assert first.p_holm < ALARM


def test_a_distorted_field_shows_in_the_image() -> None:
    data = campaign(40, 62)
    position = data.position.copy()
    # A tenth of a millimetre at the edge of the field, in Y alone.
    position[..., 1] += 1e-4 * (position[..., 1] / 0.05) ** 3
    first = cells_of(replace(data, position=position))[0]
    assert (first.channel, first.covariate) == ("image Y", "field Y")
    assert first.p_holm < ALARM


def test_restitution_that_depends_on_speed_shows_in_the_normal_jump_against_it() -> None:
    first = cells_of(campaign(40, 63, hidden=Hidden(slope=0.05)))[0]
    assert first.channel == "relative velocity n"
    assert first.covariate in {"ln v_n", "ln v_s/v_n"}
    assert first.p_holm < ALARM


@pytest.mark.long
@pytest.mark.parametrize(("position", "rotation"), [(1.3, 0.8), (0.6, 1.5)])
def test_misstated_sigmas_do_not_alarm(position: float, rotation: float) -> None:
    smallest = []
    for seed in range(4):
        data = campaign(30, 640 + seed)
        data = data.with_sigmas(position * data.position_sigma, rotation * data.rotation_sigma)
        smallest.append(cells_of(data)[0].p_holm)
    assert min(smallest) > ALARM


def test_a_covariate_that_never_changes_is_one_number_and_no_fault() -> None:
    data = replace(campaign(20, 65), covariates={"order": np.zeros(20)})
    cells = [cell for cell in cells_of(data) if cell.covariate == "order"]
    assert len(cells) == 12
    assert all(cell.freedom <= 1 for cell in cells)


@pytest.mark.parametrize("shots", [1, 2])
def test_of_two_shots_nothing_remains_without_the_two_strongest(shots: int) -> None:
    assert {cell.p_rest for cell in cells_of(campaign(shots, 63))} == {1.0}


def test_a_fit_that_ends_a_little_before_its_minimum_shows_no_more_structure() -> None:
    """0.3 standard errors off in each parameter cost 0.3 of chi-squared, and 7 in single cells."""
    data = campaign(40, 17)
    fit = fit_campaign(data)
    step = 0.3 * np.sqrt(np.diag(fit.covariance)) * np.array([1.0, -1.0, 1.0])
    theory = fit.theory.at(fit.theory.vector + step)
    short = replace(fit, theory=theory).with_states(own_states(data, fit.states, theory))
    found = (lackoffit.cells_of(data, one) for one in (fit, short))
    here, there = ({(cell.channel, cell.covariate): cell.chi2 for cell in each} for each in found)
    assert max(abs(here[name] - there[name]) for name in here) < 0.2


def with_turning_b(share: float) -> PoseData:
    """Return spheres of which b is seen to turn on after contact, by a share of what may be shared.

    About X, alike in all shots: 1.57 slow errors over a flight's time is the worst of a rate.
    """
    data = campaign(60, 91, position_sigma=2e-6, rotation_sigma=2e-4)
    slow = SlowErrors(position_m=1e-6, rotation_rad=1e-4, shared_m=4e-6)
    worst = 1.57 * slow.common_rad / (data.times_s[0, -1] / 2)
    since = np.maximum(data.times_s - data.times_s[:, 11:13].mean(axis=1)[:, None], 0.0)
    vectors = share * worst * since[..., None] * np.array([1.0, 0.0, 0.0])
    turned = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix()
    rotation = data.rotation.copy()
    rotation[:, :, 1] = turned.reshape(*since.shape, 3, 3) @ rotation[:, :, 1]
    return replace(data, rotation=rotation, slow=slow)


def test_a_spin_within_what_measuring_shares_is_no_alarm() -> None:
    assert not any(alarms(c, 60) for c in cells_of(with_turning_b(0.6)))
    bare = replace(with_turning_b(0.6), slow=NO_SLOW_ERRORS)
    assert any(alarms(c, 60) for c in cells_of(bare))


def test_a_spin_beyond_what_measuring_shares_alarms() -> None:
    assert any(alarms(c, 60) and "spin t" in c.channel for c in cells_of(with_turning_b(4.0)))
