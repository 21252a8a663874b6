"""Shots foretold: errors that hold on shots fired afterwards, and settings that are refused."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.errors import LaunchRefusedError
from analysis.launch.agreement import agreement_of, residual_left_out
from analysis.launch.fit import fit_touches
from analysis.launch.prediction import Limits
from analysis.launch.result import LaunchFit
from analysis.launch.settings import LaunchSettings, in_turn
from analysis.launch.touch import observed_touch, states_of
from analysis.model.predict.state import MOTION, POINT, TILT, TIME, TURN_A, TURN_B
from tests.unit.analysis.launch.fired import SIGMA, fired

RIG = Limits(pressure_kpa=(5.0, 120.0), offset_mm=(0.0, 24.0))


@cache
def fitted() -> LaunchFit:
    touches, settings = fired(150, 31)
    return fit_touches(touches, settings)


def one_shot(pressure_kpa: float = 50.0, offset_mm: float = 6.0) -> LaunchSettings:
    return in_turn(np.full((1, 2), pressure_kpa), np.array([offset_mm * 1e-3]))


def test_shots_fired_afterwards_fall_within_the_errors_foretold() -> None:
    touches, settings = fired(200, 32)
    foretold = fitted().predict(settings, RIG)
    measured = states_of(touches.rows, touches.time_s)
    tilt = np.stack(foretold.states.tangents(), axis=-1)
    across = (measured.normal - foretold.states.normal)[:, None] @ tilt
    step = np.zeros((200, 24))
    step[:, TILT] = across[:, 0]
    step[:, POINT] = measured.point - foretold.states.point
    step[:, MOTION] = observed_touch(measured)[:, :12] - observed_touch(foretold.states)[:, :12]
    noise = np.zeros(24)
    noise[MOTION], noise[POINT], noise[TILT] = SIGMA[:12], SIGMA[12:15], SIGMA[15:]
    own = slice(POINT.start, MOTION.stop)
    covariance = foretold.covariance[:, own, own] + np.diag(noise[own] ** 2)
    solved = np.linalg.solve(covariance, step[:, own, None])[..., 0]
    squares = (step[:, own] * solved).sum(axis=1)
    # Chi-squared of 17 degrees of freedom a shot.
    assert squares.mean() == pytest.approx(17.0, abs=4 * np.sqrt(34 / 200) + 0.8)
    pulls = step[:, own] / np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    assert pulls.std(axis=0) == pytest.approx(np.ones(17), abs=0.3)


def test_what_no_setting_decides_is_left_open() -> None:
    covariance = fitted().predict(one_shot()).covariance[0]
    assert covariance[TIME, TIME] == pytest.approx(np.zeros((1, 1)), abs=1e-30)
    drawn = Rotation.random(200_000, random_state=1).as_rotvec()
    for turn in (TURN_A, TURN_B):
        assert covariance[turn, turn] == pytest.approx(np.cov(drawn.T), abs=0.02)


def test_covariances_are_symmetric_and_positive() -> None:
    touches, settings = fired(20, 33)
    del touches
    foretold = fitted().predict(settings)
    matrices = foretold.covariance[:, 1:, 1:]
    assert matrices == pytest.approx(np.swapaxes(matrices, 1, 2), rel=1e-6, abs=1e-15)
    scale = np.sqrt(np.diagonal(matrices, axis1=1, axis2=2))
    unit = matrices / scale[:, :, None] / scale[:, None, :]
    assert np.linalg.eigvalsh(unit).min() > 0


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (one_shot(pressure_kpa=130.0), "pressure a of 130 kPa, the rig allows 5 to 120 kPa"),
        (one_shot(pressure_kpa=4.0), "pressure a of 4 kPa"),
        (one_shot(offset_mm=24.5), "offset of 24.5 mm, the rig allows 0 to 24 mm"),
        (one_shot(offset_mm=np.nan), "offset of nan mm"),
    ],
)
def test_settings_outside_the_rig_are_refused(settings: LaunchSettings, words: str) -> None:
    with pytest.raises(LaunchRefusedError, match=words):
        fitted().predict(settings, RIG)


def test_the_ends_of_the_rig_are_allowed() -> None:
    ends = in_turn(np.array([[120.0, 120.0], [20.0, 20.0]]), np.array([0.0, 24.0e-3]))
    assert len(fitted().predict(ends, RIG).states.time_s) == 2


def test_a_pressure_below_the_friction_leaves_the_sphere_in_its_tube() -> None:
    pressures = np.array([[50.0, 50.0], [50.0, 5.2]])
    with pytest.raises(LaunchRefusedError, match=r"settings 1: 5\.2 kPa leave sphere b"):
        fitted().predict(in_turn(pressures, np.zeros(2)), RIG)


def test_tracks_that_pass_each_other_are_refused() -> None:
    with pytest.raises(LaunchRefusedError, match="at an offset of 26 mm the spheres miss"):
        fitted().predict(one_shot(offset_mm=26.0))


def test_the_error_left_out_is_that_of_a_fit_without_the_shot() -> None:
    touches, settings = fired(25, 34)
    whole = fit_touches(touches, settings)
    promised = residual_left_out(whole)
    for shot in (3, 17):
        kept = np.arange(25) != shot
        without = fit_touches(touches.of_shots(kept), settings.of_shots(kept))
        alone = settings.of_shots(~kept)
        row = without.predict(alone)
        back = np.linalg.inv(row.predicted.by_muzzle)
        error = (back @ (touches.rows[[shot]] - row.predicted.touch)[..., None])[0, :, 0]
        sigma = np.sqrt(np.diag(whole.compared.variance(whole.scatter)[shot]))
        # The scatter is estimated without the shot as well: weights differ a little.
        assert promised[shot] / sigma == pytest.approx(error / sigma, abs=0.15)


def test_the_table_of_agreement_counts_scatters_and_foretells() -> None:
    rows = {row.quantity: row for row in agreement_of(fitted())}
    speed, offset = rows["speed"], rows["track offset X"]
    assert (speed.count, speed.unit, offset.count, offset.unit) == (300, "m/s", 150, "mm")
    assert 290 < speed.freedom < 300
    for row in rows.values():
        assert row.chi2 > 1.5 * row.freedom
        assert row.chi2_with_scatter == pytest.approx(row.freedom, rel=1e-6)
        assert row.prediction_rms > row.scatter * 0.9
    mean = np.sqrt((fitted().compared.speed ** 2).mean())
    assert speed.scatter == pytest.approx(0.008 * mean, rel=0.15)
    assert speed.prediction_rms == pytest.approx(0.008 * mean, rel=0.2)
