"""The error on shots left out: one when nothing is missing, and what honest refits would give."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.predict.linear import whitened_residual
from analysis.model.predict.prediction import predict
from analysis.model.predict.state import SIZE, ShotStates
from analysis.model.predict.theory import Theory
from analysis.model.verdict.crossvalidation import prediction_error
from tests.unit.analysis.model.chosen import chosen
from tests.unit.analysis.model.hard_spheres import campaign

UNITS = np.array([1e-5] + [1e-5] * 3 + [1e-3] * 2 + [1e-2] * 6 + [1.0] * 6 + [1e-2] * 6)


def test_the_error_is_one_within_its_sampling_error_when_nothing_is_missing() -> None:
    found = [prediction_error(data, fit_campaign(data)) for data in map(thirty, range(10))]
    away = np.array([(error.value - 1) / error.sampling for error in found])
    assert np.abs(away).max() < 4
    assert abs(away.mean()) < 4 / np.sqrt(10)
    # Thirty shots, 12 frames after contact, 12 numbers each.
    assert found[0].sampling == pytest.approx(np.sqrt(0.5 / (30 * 12 * 12)), rel=1e-9)


def thirty(seed: int) -> PoseData:
    return campaign(30, 200 + seed)


def refitted(data: PoseData, fit: Fit) -> float:
    """Return the whitened error by leaving out, refitting and predicting in so many words."""
    folds = np.random.default_rng(0).permutation(len(data.shots)) % 5
    total, count = 0.0, 0
    for fold in range(5):
        others = fit_campaign(data.of_shots(folds != fold))
        for s in np.flatnonzero(folds == fold):
            one = np.arange(len(data.shots)) == s
            own = data.of_shots(one)
            square, numbers = left_out(own, fit.states.of_shots(one), others.theory)
            total, count = total + square, count + numbers
    return float(np.sqrt(total / count))


def left_out(data: PoseData, start: ShotStates, theory: Theory) -> tuple[float, int]:
    """Fit a shot before contact; return r' S^-1 r of the frames after it, and their numbers."""
    after = np.repeat(data.times_s[0] > start.time_s[0], 12)

    def residual(step: np.ndarray) -> np.ndarray:
        return whitened_residual(
            data, predict(data, start.moved((UNITS * step)[None]), theory)
        ).ravel()

    early = least_squares(lambda step: residual(step)[~after], np.zeros(SIZE), method="lm")
    slopes = np.stack(
        [(residual(early.x + d) - residual(early.x - d)) / 2e-3 for d in 1e-3 * np.eye(SIZE)],
        axis=1,
    )
    spread = np.linalg.inv(slopes[~after].T @ slopes[~after])
    covariance = np.eye(after.sum()) + slopes[after] @ spread @ slopes[after].T
    rest = residual(early.x)[after]
    return float(rest @ np.linalg.solve(covariance, rest)), int(after.sum())


@pytest.mark.parametrize("stretch", [1.0, pytest.param(1.002, marks=pytest.mark.long)])
def test_the_error_is_that_of_leaving_out_refitting_and_predicting(stretch: float) -> None:
    data = campaign(10, 31)
    data = replace(data, position=stretch * data.position)
    fit = fit_campaign(data)
    assert prediction_error(data, fit).value == pytest.approx(refitted(data, fit), rel=0.03)


def test_the_error_rises_with_a_hidden_effect_and_falls_back_when_it_is_added() -> None:
    data = campaign(30, 32)
    stretched = replace(data, position=1.003 * data.position)
    base = fit_campaign(stretched)
    [scale] = chosen("image-scale")
    added = fit_campaign(stretched, base.theory.with_effect(scale), base)
    without, with_it = (prediction_error(stretched, fit) for fit in (base, added))
    true = prediction_error(data, fit_campaign(data))
    assert without.value > 1 + 10 * without.sampling
    assert with_it.value == pytest.approx(true.value, abs=0.5 * true.sampling)


def test_one_shot_is_predicted_with_the_parameters_it_gave() -> None:
    data = campaign(1, 33)
    error = prediction_error(data, fit_campaign(data))
    assert abs(error.value - 1) < 5 * error.sampling
