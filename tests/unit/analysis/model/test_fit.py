"""The fit finds the law, says how well, and leaves chi-squared at one when nothing is missing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.model.data.gather import gather_poses
from analysis.model.data.inside import without_contact_frames
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.fitting.outliers import clean
from simulators.challenge.campaign import run_campaign
from simulators.challenge.folder import write_folder
from simulators.challenge.nature import Nature
from tests.unit.analysis.model.hard_spheres import campaign

LAW = {"e": 0.74, "mu": 0.08, "beta0": 0.5}


@pytest.fixture(scope="module")
def fits() -> list[Fit]:
    return [fit_campaign(campaign(40, seed)) for seed in range(8)]


def test_chi_squared_per_degree_of_freedom_is_one_when_nothing_is_missing(fits: list[Fit]) -> None:
    sampling = np.sqrt(2 / fits[0].freedom)
    values = np.array([fit.chi2_per_dof for fit in fits])
    assert all(fit.converged for fit in fits)
    assert abs(values.mean() - 1) < 3 * sampling / np.sqrt(len(fits))
    assert np.abs(values - 1).max() < 4 * sampling


def test_the_degrees_of_freedom_are_residuals_less_24_a_shot_less_the_law(fits: list[Fit]) -> None:
    assert fits[0].freedom == 40 * 24 * 12 - 40 * 24 - 3


def test_the_law_is_found_within_its_stated_errors(fits: list[Fit]) -> None:
    pulls = np.array(
        [
            [
                (fit.parameters()[n].value - true) / fit.parameters()[n].sigma
                for n, true in LAW.items()
            ]
            for fit in fits
        ]
    )
    assert np.abs(pulls).max() < 4
    assert 0.6 < np.sqrt((pulls**2).mean()) < 1.4


def test_a_shot_off_by_a_wild_start_does_not_spoil_the_others() -> None:
    data = campaign(20, 3)
    position = data.position.copy()
    position[4, 2:5, 0, 1] += 0.004
    wild = fit_campaign(replace(data, position=position))
    clean = fit_campaign(data)
    others = np.arange(20) != 4
    assert wild.shot_chi2[4] > 100 * clean.shot_chi2[4]
    assert np.median(wild.shot_chi2[others] / clean.shot_chi2[others]) < 1.5


def test_frames_that_were_not_measured_do_not_count() -> None:
    data = campaign(20, 5)
    mask = np.zeros(data.times_s.shape, dtype=bool)
    mask[:, ::3] = True
    fit = fit_campaign(data.without(mask))
    assert fit.residuals == 20 * 16 * 12
    assert abs(fit.chi2_per_dof - 1) < 5 * np.sqrt(2 / fit.freedom)


def test_a_shot_between_rolling_and_sliding_does_not_hold_few_others_on_its_wrong_side(
    tmp_path: Path,
) -> None:
    write_folder(tmp_path / "few", run_campaign(Nature(), 400_011, shots=5))
    fit = clean(without_contact_frames(gather_poses(tmp_path / "few")[1])).fit
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=5 * np.sqrt(2 / fit.freedom))
    assert fit.theory.law.beta0 == pytest.approx(0.5, abs=0.01)
