"""Derivatives of the prediction agree with differences of the prediction itself."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import ContactLaw
from analysis.model.fitting.fit import START, fit_campaign
from analysis.model.fitting.normal import solve_blocks
from analysis.model.predict.comparison import difference, weights
from analysis.model.predict.linear import left_jacobian, linearise
from analysis.model.predict.prediction import predict
from analysis.model.predict.state import SIZE
from analysis.model.predict.theory import Theory
from analysis.motion.rotation import rotation_matrix, rotation_vector
from tests.unit.analysis.model.hard_spheres import campaign

STEPS = np.array([1e-7] + [1e-7] * 3 + [1e-6] * 2 + [1e-5] * 6 + [1e-3] * 6 + [1e-6] * 6)


@pytest.fixture(scope="module")
def fitted():
    data = campaign(6, 1)
    return data, fit_campaign(data)


@pytest.mark.parametrize("number", range(SIZE))
def test_the_derivative_by_each_of_the_24_numbers_is_that_of_the_prediction(fitted, number) -> None:
    data, fit = fitted
    analytic = linearise(data, fit.states, fit.theory).by_state[..., number]
    step = np.zeros((6, SIZE))
    step[:, number] = STEPS[number]
    ahead = predict(data, fit.states.moved(step), fit.theory)
    behind = predict(data, fit.states.moved(-step), fit.theory)
    change = (difference(behind, ahead) * weights(data)).reshape(len(data.shots), -1)
    numeric = change / (2 * STEPS[number])
    assert np.abs(analytic - numeric).max() < 2e-4 * np.abs(numeric).max()


def test_eliminating_the_shots_gives_the_step_of_the_whole_system(fitted) -> None:
    data, fit = fitted
    line = linearise(data, fit.states, Theory(START))
    shots, parameters = 6, 3
    whole = np.zeros((line.residual.size, SIZE * shots + parameters))
    rows = line.residual.shape[1]
    for s in range(shots):
        own = slice(rows * s, rows * (s + 1))
        whole[own, SIZE * s : SIZE * (s + 1)] = line.by_state[s]
        whole[own, -parameters:] = line.by_theory[s]
    dense = np.linalg.lstsq(whole, line.residual.ravel(), rcond=None)[0][-parameters:]
    by_state = np.swapaxes(line.by_state, 1, 2)
    coupling = by_state @ line.by_theory
    eliminated = solve_blocks(by_state @ line.by_state, coupling)
    by_theory = np.swapaxes(line.by_theory, 1, 2)
    matrix = (by_theory @ line.by_theory - np.swapaxes(coupling, 1, 2) @ eliminated).sum(axis=0)
    own_gradient = by_state @ line.residual[..., None]
    gradient = by_theory @ line.residual[..., None]
    gradient = (gradient - np.swapaxes(eliminated, 1, 2) @ own_gradient).sum(axis=0)[:, 0]
    assert np.linalg.solve(matrix, gradient) == pytest.approx(dense, rel=1e-4)


def test_the_left_jacobian_is_that_of_the_rotation_vector() -> None:
    rng = np.random.default_rng(2)
    for vector in (np.zeros(3), 1e-6 * rng.normal(size=3), *rng.normal(0, 0.8, (10, 3))):
        for axis in np.eye(3):
            turned = rotation_matrix(vector + 1e-6 * axis) @ rotation_matrix(vector).T
            assert left_jacobian(vector) @ axis == pytest.approx(
                rotation_vector(turned) / 1e-6, abs=1e-5
            )


@pytest.mark.parametrize(
    "effect",
    [effect for effect in CATALOGUE if not isinstance(effect, ContactLaw)],
    ids=lambda effect: effect.name,
)
def test_an_effect_that_is_off_leaves_the_prediction_as_it_was(fitted, effect) -> None:
    data, fit = fitted
    without = predict(data, fit.states, fit.theory)
    off = predict(data, fit.states, fit.theory.with_effect(effect))
    assert np.array_equal(without.position, off.position)
    assert np.array_equal(without.rotation, off.rotation)
