import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from analysis.motion.alignment import rotation_from_directions
from analysis.motion.rotation import (
    quaternion,
    rotation_matrix,
    rotation_vector,
)

component = st.floats(-1.0, 1.0)
axes = (
    st.tuples(component, component, component)
    .filter(lambda v: sum(x * x for x in v) > 1e-2)
    .map(lambda v: np.array(v) / np.linalg.norm(v))
)
angles = st.one_of(
    st.floats(0.0, math.pi - 1e-6),
    st.floats(1e-10, 1e-3),
    st.floats(math.pi - 1e-3, math.pi - 1e-6),
)


@given(axis=axes, angle=angles)
def test_the_matrix_of_a_rotation_vector_is_that_of_scipy(axis: np.ndarray, angle: float) -> None:
    expected = Rotation.from_rotvec(angle * axis).as_matrix()
    np.testing.assert_allclose(rotation_matrix(angle * axis), expected, atol=1e-12)


@given(axis=axes, angle=angles)
def test_axis_and_angle_come_back_from_the_matrix(axis: np.ndarray, angle: float) -> None:
    found = rotation_vector(Rotation.from_rotvec(angle * axis).as_matrix())
    assert np.linalg.norm(found) == pytest.approx(angle, abs=1e-9)
    np.testing.assert_allclose(found, angle * axis, atol=1e-6)


@pytest.mark.parametrize("largest", [0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("short_of_half_a_turn", [1e-3, 1e-6, 1e-8])
def test_each_largest_axis_component_has_its_own_way_near_half_a_turn(
    largest: int, sign: float, short_of_half_a_turn: float
) -> None:
    axis = np.array([0.3, -0.2, 0.25])
    axis[largest] = 0.9 * sign
    axis /= np.linalg.norm(axis)
    angle = math.pi - short_of_half_a_turn
    found = rotation_vector(Rotation.from_rotvec(angle * axis).as_matrix())
    assert np.linalg.norm(found) == pytest.approx(angle, abs=1e-9)
    np.testing.assert_allclose(found, angle * axis, atol=4e-7)


@given(axis=axes)
def test_half_a_turn_has_an_axis_of_either_sign(axis: np.ndarray) -> None:
    found = rotation_vector(2 * np.outer(axis, axis) - np.eye(3))
    assert np.linalg.norm(found) == pytest.approx(math.pi, abs=1e-7)
    assert abs(float(found @ axis)) == pytest.approx(math.pi, abs=1e-7)


def test_no_rotation_has_the_angle_zero() -> None:
    assert not rotation_vector(np.eye(3)).any()


def test_stacks_of_rotations_keep_their_shape() -> None:
    turns = Rotation.random(6, rng=np.random.default_rng(2))
    stacked = turns.as_matrix().reshape(2, 3, 3, 3)
    vectors = rotation_vector(stacked)
    np.testing.assert_allclose(vectors.reshape(6, 3), turns.as_rotvec(), atol=1e-12)
    np.testing.assert_allclose(rotation_matrix(vectors), stacked, atol=1e-12)


@given(axis=axes, angle=angles)
def test_quaternions_are_those_of_scipy_with_the_scalar_first(
    axis: np.ndarray, angle: float
) -> None:
    turn = Rotation.from_rotvec(angle * axis)
    expected = turn.as_quat(canonical=True, scalar_first=True)
    found = quaternion(turn.as_matrix())
    assert found[0] >= 0.0
    np.testing.assert_allclose(found, expected, atol=1e-6)


def scattered(number: int, rng: np.random.Generator) -> np.ndarray:
    directions = rng.normal(size=(number, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


@given(axis=axes, angle=angles, number=st.integers(3, 9), seed=st.integers(0, 1000))
def test_exact_directions_give_their_rotation(
    axis: np.ndarray, angle: float, number: int, seed: int
) -> None:
    before = scattered(number, np.random.default_rng(seed))
    turn = Rotation.from_rotvec(angle * axis).as_matrix()
    after = before @ turn.T
    np.testing.assert_allclose(rotation_from_directions(before, after), turn, atol=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_noisy_weighted_directions_give_the_rotation_of_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    before, weights = scattered(7, rng), rng.uniform(0.1, 1.0, 7)
    after = before @ Rotation.random(rng=rng).as_matrix().T + rng.normal(0, 0.05, (7, 3))
    expected = Rotation.align_vectors(after, before, weights)[0].as_matrix()
    found = rotation_from_directions(before, after, weights)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert np.linalg.det(found) == pytest.approx(1.0)


def test_directions_in_one_plane_still_give_a_proper_rotation() -> None:
    before = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.6, 0.8, 0.0]])
    turn = Rotation.from_rotvec([0.4, 1.9, -0.3]).as_matrix()
    found = rotation_from_directions(before, before @ turn.T)
    np.testing.assert_allclose(found, turn, atol=1e-12)


def test_noise_leaves_the_rotation_orthogonal() -> None:
    rng = np.random.default_rng(1)
    before = scattered(6, rng)
    after = before @ Rotation.from_rotvec([0.0, 0.0, 0.5]).as_matrix().T
    found = rotation_from_directions(before, after + rng.normal(0, 0.05, after.shape))
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-12)
