"""Paths that a model predicts from before the contact, beside the measured ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.model.agreement.freed import paths_document, predicted_paths
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit, fit_campaign
from tests.unit.analysis.model.hard_spheres import campaign

SHOTS = 12


@pytest.fixture(scope="module")
def data() -> PoseData:
    return campaign(SHOTS, 74)


@pytest.fixture(scope="module")
def fit(data: PoseData) -> Fit:
    return fit_campaign(data)


def test_a_true_law_predicts_the_paths_within_the_noise(data: PoseData, fit: Fit) -> None:
    for path in predicted_paths(data, fit):
        assert path.gap < 15 * np.median(data.position_sigma)


def test_spheres_that_leave_too_fast_part_from_the_prediction_after_contact_alone(
    data: PoseData, fit: Fit
) -> None:
    speed = 0.5
    tau = np.maximum(data.times_s - fit.states.time_s[:, None], 0)
    away = speed * tau[..., None] * fit.states.normal[:, None]
    moved = replace(data, position=data.position + np.stack([-away, away], axis=2))
    for path in predicted_paths(moved, fit):
        after = path.time_s > path.contact_s
        before = np.linalg.norm((path.predicted - path.measured)[~after], axis=-1)
        assert np.nanmax(before) < 15 * np.median(data.position_sigma)
        lasts = path.time_s[after].max() - path.contact_s
        assert path.gap == pytest.approx(speed * lasts, rel=0.1)


def test_a_typical_shot_comes_first_then_the_largest_and_the_smallest_gap(
    data: PoseData, fit: Fit
) -> None:
    typical, largest, smallest = paths_document(data, fit)
    assert smallest["gap_mm"] <= typical["gap_mm"] <= largest["gap_mm"]
    assert len({one["shot"] for one in (typical, largest, smallest)}) == 3


def test_what_was_not_measured_is_null(data: PoseData, fit: Fit) -> None:
    sigma = data.position_sigma.copy()
    sigma[:, 3, 1] = np.inf
    shown = paths_document(replace(data, position_sigma=sigma), fit)[0]
    assert shown["measured"][3][1] is None
    assert shown["gaps"][3][1] is None
    assert shown["measured"][3][0] is not None


def test_any_shot_is_asked_for_by_its_number(data: PoseData, fit: Fit) -> None:
    for one in paths_document(data, fit):
        assert paths_document(data, fit, one["shot"]) == [one]
    shown = {paths_document(data, fit, int(number))[0]["shot"] for number in data.shots}
    assert shown == set(map(int, data.shots))
    assert paths_document(data, fit, int(data.shots.max()) + 1) == []


def test_a_direction_that_no_view_shows_leaves_the_others_measured(
    data: PoseData, fit: Fit
) -> None:
    sigma = np.broadcast_to(data.position_sigma, data.position.shape).copy()
    sigma[..., 2] = np.inf
    for shown in predicted_paths(replace(data, position_sigma=sigma), fit):
        assert np.isfinite(shown.measured).all()
        assert np.array_equal(shown.measured[..., 2], shown.predicted[..., 2])
        assert shown.gap < 15 * np.median(data.position_sigma)
