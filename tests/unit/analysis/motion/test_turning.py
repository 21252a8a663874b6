import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from analysis.motion.turning import turn_between, turn_slopes, turned

component = st.floats(-3.0, 3.0)
vectors = st.tuples(component, component, component).map(np.array)
short = st.floats(0.0, 1.0).map(lambda share: share * 3.1415)


@given(vectors, vectors)
def test_a_vector_turns_a_rotation_about_itself_by_its_length(first, vector) -> None:
    start = Rotation.from_rotvec(first)
    expected = (Rotation.from_rotvec(vector) * start).as_matrix()
    np.testing.assert_allclose(turned(vector, start.as_matrix()), expected, atol=1e-12)


@given(vectors, vectors.filter(lambda v: np.linalg.norm(v) > 1e-3), short)
def test_the_turn_between_two_rotations_is_found_at_every_angle(first, axis, angle) -> None:
    start = Rotation.from_rotvec(first)
    turn = angle * axis / np.linalg.norm(axis)
    end = Rotation.from_rotvec(turn) * start
    found = turn_between(start.as_matrix(), end.as_matrix())
    np.testing.assert_allclose(found, turn, atol=1e-9)


def test_half_a_turn_has_its_axis_up_to_its_sign() -> None:
    for axis in np.eye(3):
        end = Rotation.from_rotvec(np.pi * axis).as_matrix()
        found = turn_between(np.eye(3), end)
        np.testing.assert_allclose(np.abs(found), np.pi * axis, atol=1e-9)


def test_no_turn_is_no_vector() -> None:
    np.testing.assert_array_equal(turn_between(np.eye(3), np.eye(3)), np.zeros(3))


spins = vectors.map(lambda vector: 20.0 * vector)


@given(spins, st.floats(-0.05, 0.05))
def test_slopes_of_a_turn_are_differences_of_turns(spin, time_s) -> None:
    def orientation(numbers: np.ndarray) -> Rotation:
        start, change = numbers[:3], numbers[3:]
        return Rotation.from_rotvec((spin + change) * time_s) * Rotation.from_rotvec(start)

    middle, step = orientation(np.zeros(6)), 1e-6
    steps = [(orientation(step * row) * middle.inv()).as_rotvec() / step for row in np.eye(6)]
    np.testing.assert_allclose(turn_slopes(spin, time_s), np.transpose(steps), atol=1e-5)
