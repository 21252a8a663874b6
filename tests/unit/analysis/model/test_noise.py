"""How large the noise really is comes out of the residuals, positions and orientations apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.model.data.evidence import weighed
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.fitting.noise import noise_scales, rescaled
from analysis.model.predict.comparison import compare
from analysis.setup import SlowErrors
from tests.unit.analysis.model.hard_spheres import POSITION_SIGMA, ROTATION_SIGMA, campaign

SHOTS = 60
SAMPLING = np.sqrt(0.5 / (SHOTS * (24 * 6 - 24)))
"""Of the root of chi-squared, with 24 of each shot's 48 numbers of free flight for each kind."""


@pytest.mark.parametrize(("position", "rotation"), [(1.0, 1.0), (1.3, 0.8), (0.5, 3.0)])
def test_misstated_sigmas_are_found_and_put_right(position: float, rotation: float) -> None:
    true = campaign(SHOTS, 41)
    stated = true.with_sigmas(position * true.position_sigma, rotation * true.rotation_sigma)
    fit = fit_campaign(stated)
    of_position, of_rotation = noise_scales(stated, fit)
    assert of_position.value == pytest.approx(1 / position, rel=4 * SAMPLING)
    assert of_rotation.value == pytest.approx(1 / rotation, rel=4 * SAMPLING)
    for scale in (of_position, of_rotation):
        assert scale.sigma == pytest.approx(SAMPLING * scale.value, rel=0.01)
    righted = rescaled(stated, fit)
    assert righted.position_sigma == pytest.approx(POSITION_SIGMA, rel=4 * SAMPLING)
    assert righted.rotation_sigma == pytest.approx(ROTATION_SIGMA, rel=4 * SAMPLING)


def test_orientations_that_err_by_axis_are_scored_about_each_by_its_own_error() -> None:
    true = campaign(SHOTS, 45)
    rng = np.random.default_rng(46)
    further = rng.normal(size=(true.rotation.size // 9, 3)) * ROTATION_SIGMA * (0.0, 1.5, 0.5)
    turned = Rotation.from_rotvec(further).as_matrix().reshape(true.rotation.shape)
    variances = ROTATION_SIGMA**2 * np.array([1.0, 1.0 + 1.5**2, 1.0 + 0.5**2])
    stated = replace(
        true.with_sigmas(
            true.position_sigma, np.full_like(true.rotation_sigma, np.sqrt(variances.mean()))
        ),
        rotation=turned @ true.rotation,
        turn_shape=np.broadcast_to(np.diag(variances / variances.mean()), true.rotation.shape),
    )
    fit = fit_campaign(stated)
    residual = compare(stated, fit.states, fit.theory)[0].residual
    about = residual.reshape(SHOTS, 2, 2, -1, 3)[:, :, 1]
    # A start and a spin about each axis are fitted to the frames of a sphere.
    left = 1 - 2 / about.shape[2]
    by_axis = np.sqrt((about**2).mean(axis=(0, 1, 2)) / left)
    assert by_axis == pytest.approx(np.ones(3), rel=0.06)


def test_without_orientations_their_scale_is_left_as_stated() -> None:
    data = campaign(20, 42)
    blind = replace(data, rotation_sigma=np.full_like(data.rotation_sigma, np.inf))
    position, rotation = noise_scales(blind, fit_campaign(blind))
    assert rotation.value == 1.0
    assert rotation.sigma == np.inf
    assert position.value == pytest.approx(1.0, rel=0.06)


def test_a_law_of_contact_that_is_wrong_does_not_make_the_noise_look_larger() -> None:
    data = campaign(SHOTS, 43)
    fit = fit_campaign(data)
    wrong = replace(fit, theory=fit.theory.at(np.array([0.5, 0.3, -0.5])))
    for scale in noise_scales(data, wrong):
        assert scale.value == pytest.approx(1.0, abs=4 * SAMPLING)


def with_slow_errors(data: PoseData, share: float) -> PoseData:
    slow = SlowErrors(position_m=share * POSITION_SIGMA, rotation_rad=share * ROTATION_SIGMA)
    return replace(data, slow=slow)


def test_scatter_that_slow_errors_add_to_stated_sigmas_is_in_the_sigmas_of_a_fit() -> None:
    true = campaign(SHOTS, 44)
    added, excess = 0.2, np.hypot(1.0, 0.2)
    stated = true.with_sigmas(true.position_sigma / excess, true.rotation_sigma / excess)
    assert weighed(stated).noise == (1.0, 1.0), "within four errors of what is stated"
    of_slow = weighed(with_slow_errors(stated, added)).noise
    assert of_slow == pytest.approx((excess, excess), abs=3 * SAMPLING)
    assert min(of_slow) > 1.0


def test_slow_errors_enlarge_sigmas_by_no_more_than_their_own_size() -> None:
    true = campaign(SHOTS, 44)
    stated = true.with_sigmas(true.position_sigma / 1.02, true.rotation_sigma / 1.02)
    of_slow = weighed(with_slow_errors(stated, 0.1)).noise
    assert max(of_slow) <= np.sqrt(1.0 + 0.1**2 * 1.02**2 * 2)
    assert max(of_slow) > 1.0
