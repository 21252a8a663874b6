"""Compiled residuals and slopes beside rotation vectors of scipy and differences of flights."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.model.loops.flight import free_flight
from analysis.model.loops.misfit import misfits, put_whitened, slopes_of

SHOTS, FRAMES = 3, 5
TIMES = np.array([-0.009, -0.002, 0.001, 0.004, 0.011])


def sigmas() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    position = rng.uniform(1e-5, 3e-5, (SHOTS, FRAMES, 2, 3))
    rotation = rng.uniform(5e-3, 9e-3, (SHOTS, FRAMES, 2, 3))
    position[1, 2, 0, 1], rotation[0, 3, 1] = np.inf, np.inf
    return position, rotation


def blocks(position: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Sort whitened positions and turns (S, F, 2, 3) by sphere and kind, (S, 4, 3 F)."""
    own, turning = sigmas()
    both = np.stack([position / own, turns / turning], axis=3)
    return both.transpose(0, 2, 3, 1, 4).reshape(SHOTS, 4, 3 * FRAMES)


@pytest.mark.parametrize("largest", [1e-11, 1e-3, 0.5, 1.5, 1.6, 3.1, np.pi - 1e-9])
def test_residuals_are_differences_of_places_and_vectors_of_turns(largest: float) -> None:
    rng = np.random.default_rng(5)
    place, moved = rng.normal(0, 0.02, (2, SHOTS, FRAMES, 2, 3))
    axis = rng.normal(size=(SHOTS * FRAMES * 2, 3))
    vector = largest * axis / np.linalg.norm(axis, axis=1, keepdims=True)
    start = Rotation.random(len(vector), random_state=rng)
    shape = (SHOTS, FRAMES, 2, 3, 3)
    predicted = np.ascontiguousarray(start.as_matrix().reshape(shape))
    observed = (Rotation.from_rotvec(vector) * start).as_matrix().reshape(shape)
    found = misfits((place, np.ascontiguousarray(observed)), (moved, predicted), sigmas())
    expected = blocks(place - moved, vector.reshape(SHOTS, FRAMES, 2, 3))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_what_was_not_measured_has_no_residual_and_no_slope() -> None:
    place, turn = np.ones((SHOTS, FRAMES, 2, 3)), np.tile(np.eye(3), (SHOTS, FRAMES, 2, 1, 1))
    found = misfits((place, turn), (np.zeros_like(place), turn), sigmas())
    assert found[1, 0, 7] == 0
    tau = np.ones_like(place)
    slopes, _ = slopes_of((tau, tau[..., 0].copy()), (turn, turn), turn, sigmas())
    assert (slopes[1, 0, 7] == 0).all()
    assert (slopes[0, 3, 9:12] == 0).all()
    assert slopes[0, 2, 9:12].any()


@pytest.mark.parametrize("bent", [False, True])
def test_slopes_are_what_differences_of_flights_say(bent: bool) -> None:
    rng = np.random.default_rng(9)
    shape = (SHOTS, 2, 2, 3)
    motion = (rng.normal(0, 0.02, shape), rng.normal(0, 1, shape), rng.normal(0, 100, shape))
    touched = Rotation.random(4 * SHOTS, random_state=rng).as_matrix().reshape(*shape, 3)
    touched = np.ascontiguousarray(touched)
    tau = np.broadcast_to(TIMES[:, None, None], (SHOTS, FRAMES, 2, 3)).copy()
    times = (tau, tau[..., 0].copy())
    camera = rng.normal(size=(3, 3)) if bent else np.eye(3)
    none = np.zeros((0, FRAMES, 2, 3, 3))
    response = np.tile(camera, (SHOTS, FRAMES, 2, 1, 1)) if bent else none
    _, _, _, there, jacobian, turned = free_flight(times, motion, touched, 9.81)
    slopes, gram = slopes_of(times, (turned, jacobian), response, sigmas())
    np.testing.assert_allclose(gram, np.swapaxes(slopes, 2, 3) @ slopes, rtol=1e-12, atol=1e-9)
    slopes = slopes.reshape(SHOTS, 2, 2, -1, 12)
    for number in range(12):
        side, rate, axis = number // 6, number // 3 % 2, number % 3
        changed = []
        for way in (1.0, -1.0):
            one, start = tuple(part.copy() for part in motion), touched.copy()
            step = way * (1e-2 if rate else 1e-4)
            if rate:
                one[1][:, :, side, axis] += step
                one[2][:, :, side, axis] += step
            else:
                one[0][:, :, side, axis] += step
                start[:, :, side] = (
                    Rotation.from_rotvec(step * np.eye(3)[axis]).as_matrix() @ (touched[:, :, side])
                )
            place, _, _, rotation, *_ = free_flight(times, one, start, 9.81)
            change = (rotation @ np.swapaxes(there, -1, -2)).reshape(-1, 3, 3)
            turn = Rotation.from_matrix(change).as_rotvec().reshape(place.shape)
            changed.append(blocks(place @ camera.T, turn))
        expected = (changed[0] - changed[1]) / (2 * abs(step))
        found = slopes[..., number].reshape(expected.shape)
        np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(found).max())


def test_a_frame_seen_at_times_on_both_sides_of_contact_ties_the_sides() -> None:
    rng = np.random.default_rng(11)
    tau = rng.uniform(-1e-4, 1e-4, (SHOTS, FRAMES, 2, 3))
    turn, response = np.tile(np.eye(3), (2, SHOTS, FRAMES, 2, 1, 1))
    response = response + rng.normal(0, 0.1, response.shape)
    times = (tau, tau[..., 0].copy())
    slopes, gram = slopes_of(times, (turn, turn), response, sigmas())
    assert gram[:, ::2, :6, 6:].any()
    expected = np.swapaxes(slopes, 2, 3) @ slopes
    np.testing.assert_allclose(gram, expected, rtol=1e-12, atol=1e-12 * gram.max())


def test_changes_are_put_where_the_residuals_of_their_numbers_stand() -> None:
    rng = np.random.default_rng(13)
    place, turn = rng.normal(size=(2, SHOTS, FRAMES, 2, 3))
    own, turning = sigmas()
    weights = 1 / np.concatenate([own, turning], axis=3)
    column = np.zeros((SHOTS, 4, 3 * FRAMES))
    for kind, change in enumerate((place, turn)):
        put_whitened(change, weights, kind, 0.5, column)
    np.testing.assert_allclose(column, blocks(2 * place, 2 * turn), rtol=1e-14)
