"""The table of agreement: calibrated when nothing is missing, and red where something is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from analysis.launch.agreement import LaunchAgreement
from analysis.model.agreement import launch
from analysis.model.agreement.agree import agree
from analysis.model.agreement.heldout import left_out_steps
from analysis.model.agreement.table import Agreement, Row, Spread, Stage
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.rank.projector import projector
from analysis.model.verdict.crossvalidation import prediction_error
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

pytestmark = pytest.mark.long

CAMPAIGNS, SHOTS = 100, 6
STAGES = ["before contact", "after contact", "flight", "camera"]
CALM = {"before contact", "flight", "camera"}


def agreement_of(data: PoseData) -> Agreement:
    return agree(data, fit_campaign(data))


def row_of(found: Agreement, stage: str, quantity: str) -> Row:
    [part] = [part for part in found.stages if part.name == stage]
    [row] = [row for row in part.rows if row.quantity == quantity]
    return row


@pytest.fixture(scope="module")
def quiet() -> list[Agreement]:
    return [agreement_of(campaign(SHOTS, 9000 + k)) for k in range(CAMPAIGNS)]


def test_every_stage_has_its_quantities_with_units(quiet: list[Agreement]) -> None:
    assert [stage.name for stage in quiet[0].stages] == STAGES
    assert [len(stage.rows) for stage in quiet[0].stages] == [4, 10, 4, 3]
    assert {row.unit for row in quiet[0].rows} == {"mm", "mrad", "mm/s", "rad/s"}
    assert all(0 < row.freedom <= row.count for row in quiet[0].rows)


def test_p_values_are_uniform_when_nothing_is_missing(quiet: list[Agreement]) -> None:
    p_values = np.array([[row.p_value for row in found.rows] for found in quiet])
    # One of these rows would fall below a thousandth by chance in one suite of fifty.
    assert min(kstest(own, "uniform").pvalue for own in p_values.T) > 1e-3
    assert kstest(p_values.mean(axis=0), "norm", args=(0.5, 12**-0.5 / 10)).pvalue > 1e-3
    # Rows of a campaign share residuals: three times a binomial's spread.
    assert (p_values < 0.05).mean() == pytest.approx(0.05, abs=3 * (0.05 * 0.95 / 2100) ** 0.5)
    assert kstest([found.p_value for found in quiet], "uniform").pvalue > 1e-3


def test_chi_squared_is_its_degrees_of_freedom_on_average(quiet: list[Agreement]) -> None:
    chi2 = np.array([[row.chi2 for row in found.rows] for found in quiet])
    freedom = np.array([[row.freedom for row in found.rows] for found in quiet])
    error = chi2.std(axis=0) / np.sqrt(CAMPAIGNS)
    assert np.abs((chi2 - freedom).mean(axis=0) / error).max() < 4


def test_errors_lie_on_their_floor_when_nothing_is_missing() -> None:
    # Forty shots: with fewer, the error of the parameters lifts a prediction off its floor.
    many = [agreement_of(campaign(40, 9200 + k)) for k in range(8)]
    ratio = np.array([[(row.size / row.floor) ** 2 for row in found.rows] for found in many])
    white = np.array([[row.error**2 for row in found.rows] for found in many])
    spread = np.array([2 * row.sampling for row in many[0].rows]) / np.sqrt(len(many))
    assert np.abs((white.mean(axis=0) - 1) / spread).max() < 4
    assert np.abs((ratio.mean(axis=0) - 1) / spread).max() < 6


def test_speed_dependent_restitution_shows_in_the_normal_velocity_after_contact() -> None:
    found = agreement_of(campaign(40, 63, hidden=Hidden(slope=0.05)))
    worst = row_of(found, "after contact", "normal velocity")
    assert worst.p_value == min(row.p_value for row in found.rows) < 1e-6
    assert worst.size > 1.5 * worst.floor
    assert worst.error > 1.5
    assert row_of(found, "before contact", "position a").p_value > 1e-3
    assert row_of(found, "after contact", "velocity out of plane").p_value > 1e-3


def test_the_size_of_a_missing_speed_comes_out_in_its_unit() -> None:
    # The last 12 frames of every second sphere pair fly 50 mm/s too fast or too slow along n.
    data = campaign(40, 64)
    fit = fit_campaign(data)
    tau = np.maximum(data.times_s - fit.states.time_s[:, None], 0)[..., None]
    sign = np.where(np.arange(40) % 2, 0.05, -0.05)[:, None, None]
    push = sign * tau * fit.states.normal[:, None] / 2
    position = data.position + np.stack([-push, push], axis=2)
    found = agreement_of(replace(data, position=position))
    row = row_of(found, "after contact", "normal velocity")
    assert row.size == pytest.approx(50.0, rel=0.05)
    assert row.floor < 8.0


def test_a_force_between_the_spheres_shows_in_flight() -> None:
    found = agreement_of(campaign(40, 61, hidden=Hidden(pull=30.0)))
    assert row_of(found, "flight", "relative position against time").p_value < 1e-9
    assert row_of(found, "flight", "common orientation against time").p_value > 1e-3


def test_a_distorted_field_shows_in_the_camera_with_its_size() -> None:
    data = campaign(40, 62)
    position = data.position.copy()
    # Half a millimetre at the edge of the field, in Y alone.
    bent = 5e-4 * (position[..., 1] / 0.05) ** 3
    position[..., 1] += bent
    row = row_of(agreement_of(replace(data, position=position)), "camera", "image Y against place")
    assert row.p_value < 1e-9
    assert abs(row.size - 1e3 * np.sqrt((bent**2).mean())) < 3 * row.floor


def test_the_whole_prediction_error_is_that_of_the_cross_validation() -> None:
    data = campaign(20, 66)
    fit = fit_campaign(data)
    found = agree(data, fit)
    whole = prediction_error(data, fit)
    assert (found.prediction.value, found.prediction.sampling) == (whole.value, whole.sampling)
    np.testing.assert_array_equal(found.prediction.by_shot, whole.by_shot)
    assert found.chi2 / found.freedom == pytest.approx(fit.chi2_per_dof)


def test_stated_errors_that_are_too_small_are_named_by_their_factor() -> None:
    data = campaign(30, 67)
    data = data.with_sigmas(data.position_sigma / 1.3, data.rotation_sigma / 0.8)
    noise = agreement_of(data).noise
    assert [scale.value for scale in noise] == pytest.approx([1.3, 0.8], rel=0.05)


def test_a_stage_before_the_first_frame_stands_first() -> None:
    data = campaign(8, 68)
    before = Stage("launch", (Row("speed a", "mm/s", 8, 8, 7, 0.4, 1, 0.25, 9, 9),))
    found = agree(data, fit_campaign(data), (before,))
    assert [stage.name for stage in found.stages] == ["launch", *STAGES]


def test_a_launch_that_settings_foretell_has_the_scatter_as_its_floor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    speed = LaunchAgreement("speed", "m/s", 16, 14.0, 9e4, 14.0, 0.02, 0.03)
    monkeypatch.setattr(launch, "launch_agreement", lambda *_: (speed,))
    data = campaign(8, 68)
    [row] = launch.launch_stage(data, fit_campaign(data)).rows
    assert (row.quantity, row.unit, row.size, row.floor) == ("speed", "m/s", 0.03, 0.02)
    assert row.error == pytest.approx(1.5)
    assert (row.chi2, row.p_value) == (14.0, 1.0)


def test_spheres_without_orientations_have_no_rows_of_them() -> None:
    data = campaign(12, 69)
    found = agreement_of(
        data.with_sigmas(data.position_sigma, np.full_like(data.rotation_sigma, np.inf))
    )
    names = {row.quantity for row in found.rows}
    assert "position a" in names
    assert not {name for name in names if "orientation" in name or "spin" in name}
    assert all(np.isfinite([row.chi2, row.error, row.size, row.floor]).all() for row in found.rows)


def test_one_shot_alone_is_held_against_its_own_parameters() -> None:
    data = campaign(1, 70)
    fit = fit_campaign(data)
    assert not left_out_steps(projector(data, fit)).any()
    assert agree(data, fit).stages[0].name == "before contact"


def test_the_spread_of_a_plain_chi_squared_gives_its_plain_p_value() -> None:
    # 18.307 is the 95 per cent point of ten degrees of freedom in any table.
    assert Spread(10.0, 20.0).p_value(18.307) == pytest.approx(0.05, abs=1e-4)
    assert Spread(0.0, 0.0).p_value(0.0) == 1.0


def test_a_law_that_is_far_off_alarms_neither_flight_nor_camera() -> None:
    # Restitution that changes much over the range of speeds: shots miss it by ten standard errors.
    far = [agreement_of(campaign(16, 9300 + k, hidden=Hidden(slope=0.2))) for k in range(8)]
    assert min(found.chi2 / found.freedom for found in far) > 5
    p_values = np.array(
        [
            [row.p_value for stage in found.stages if stage.name in CALM for row in stage.rows]
            for found in far
        ]
    )
    assert kstest(p_values.ravel(), "uniform").pvalue > 1e-3
    assert p_values.min() > 1e-4


def test_what_one_shot_carries_is_not_shared_and_what_all_do_is() -> None:
    data = campaign(20, 9400)
    fit = fit_campaign(data)
    late = np.maximum(data.times_s - fit.states.time_s[:, None], 0.0)[..., None]
    push = 0.02 * late * fit.states.normal[:, None]

    def pushed(shots: slice) -> Row:
        moved = np.zeros_like(data.position)
        moved[shots] = np.stack([-push, push], axis=2)[shots]
        found = agreement_of(replace(data, position=data.position + moved))
        return row_of(found, "after contact", "normal velocity")

    one, every_third = pushed(slice(4, 5)), pushed(slice(None, None, 3))
    assert one.p_value < 1e-6
    assert not one.shared
    assert every_third.p_value < 1e-6
    assert every_third.shared
