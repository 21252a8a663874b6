"""What the structure that is left follows: means of channels taken out of their courses first."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from analysis.model.data.gather import gather
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.structure.findings import ALWAYS, Finding, findings
from analysis.model.structure.lackoffit import Cell
from analysis.model.structure.structure import Structure, structure
from simulators.challenge import write_challenge
from tests.unit.analysis.model.hard_spheres import campaign

SHOTS, PUSH_M_PER_S = 40, 0.02


def pushed(data: PoseData, push: np.ndarray) -> Structure:
    """Return what is left when both spheres leave along the normal by more, (S,) in m/s."""
    fit = fit_campaign(data)
    tau = np.maximum(data.times_s - fit.states.time_s[:, None], 0)[..., None, None]
    away = push[:, None, None, None] * tau * fit.states.normal[:, None, None]
    moved = replace(data, position=data.position + away)
    return structure(moved, fit_campaign(moved))


@pytest.fixture(scope="module")
def data() -> PoseData:
    return campaign(SHOTS, 73)


def test_a_constant_error_is_one_finding_and_lights_no_other_cell_of_its_row(
    data: PoseData,
) -> None:
    left = pushed(data, np.full(SHOTS, PUSH_M_PER_S))
    first, *others = findings(left.cells, left.covariates)
    assert (first.channel, first.covariate) == ("common velocity n", ALWAYS)
    own = [one for one in others if one.channel == "common velocity n"]
    assert len(own) >= 5
    assert first.deviation > 5 * max(one.deviation for one in own)
    trend = left.always("common velocity n").trend
    assert np.allclose(trend.mean, 1e3 * PUSH_M_PER_S, rtol=0.1)


def test_an_error_that_follows_the_speed_is_a_course_and_no_mean(data: PoseData) -> None:
    speed = structure(data, fit_campaign(data)).covariates["ln v_n"]
    course = (speed - speed.mean()) / speed.std()
    left = pushed(data, PUSH_M_PER_S * course)
    first = findings(left.cells, left.covariates)[0]
    assert (first.channel, first.covariate) == ("common velocity n", "ln v_n")
    cell = next(c for c in left.cells if (c.channel, c.covariate) == first_name(first))
    assert cell.mean_deviation < 0.2 * cell.course_deviation


def first_name(found: Finding) -> tuple[str, str]:
    return found.channel, found.covariate


def test_a_constant_leaves_only_noise_in_the_courses_of_its_row(data: PoseData) -> None:
    """Four smooth functions of any covariate have no part in it: chi-squared of four freedoms."""
    cells = pushed(data, np.full(SHOTS, PUSH_M_PER_S)).cells
    row = [cell for cell in cells if cell.channel == "common velocity n"]
    assert len(row) >= 5
    for cell in row:
        course, freedom = cell.course
        assert cell.chi2 > 1000
        assert freedom == 4
        assert stats.chi2.sf(course, 4) > 0.01 / len(row)


def test_a_mean_that_the_law_takes_a_part_of_lights_no_cell_of_what_has_no_say(
    tmp_path: Path,
) -> None:
    """Moments of inertia that are wrong by 8 %: whoever fires in which order changes nothing."""
    write_challenge(tmp_path / "hollow", {"inertia-factor": -0.08}, seed=7, shots=60)
    found = robust_fit(gather(tmp_path / "hollow")[1])
    left = structure(found.data, found.fit)
    own = {cell.covariate: cell for cell in left.cells if cell.channel == "relative velocity t"}
    assert own["order"].mean_deviation > 20
    for covariate in ("order", "temperature_c"):
        assert own[covariate].course_deviation < 0.25 * own[covariate].mean_deviation


def test_of_nearly_equal_courses_the_contact_is_named_before_the_setting() -> None:
    names = [
        one.covariate for one in findings([cell("pressure_a_kpa", 90), cell("ln v_n", 80)], {})
    ]
    assert names == ["ln v_n", "pressure_a_kpa"]


def test_a_setting_that_says_clearly_more_is_named_first() -> None:
    found = findings([cell("pressure_a_kpa", 400), cell("ln v_n", 80)], {})
    assert found[0].covariate == "pressure_a_kpa"


def test_a_setting_gives_way_to_a_covariate_that_it_is_correlated_with() -> None:
    speed = np.linspace(0.0, 1.0, 9)
    covariates = {"ln v_n": speed, "pressure_a_kpa": 40.0 + 3.0 * speed}
    found = findings([cell("pressure_a_kpa", 400), cell("ln v_n", 80)], covariates)
    assert found[0].covariate == "ln v_n"


def cell(covariate: str, chi2: float) -> Cell:
    return Cell(
        channel="relative velocity n",
        covariate=covariate,
        chi2=chi2,
        freedom=5,
        p_value=1e-9,
        p_holm=1e-9,
        carried_share=0.1,
        p_rest=1e-9,
    )
