"""Compiled free flight beside rotations of scipy and parabolas."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.model.loops.flight import free_flight
from analysis.motion.exponential import exponential

GRAVITY = 9.81
TIMES = np.array([-0.011, -1e-9, 0.0, 1e-7, 0.013])


@pytest.fixture
def motion() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(7)
    place, velocity = rng.normal(0, 0.02, (3, 2, 2, 3)), rng.normal(0, 1, (3, 2, 2, 3))
    return place, velocity, rng.normal(0, 150, (3, 2, 2, 3))


def touched() -> np.ndarray:
    drawn = Rotation.random(12, random_state=np.random.default_rng(8)).as_matrix()
    return np.ascontiguousarray(drawn.reshape(3, 2, 2, 3, 3))


def flown(motion: tuple[np.ndarray, np.ndarray, np.ndarray]) -> tuple[np.ndarray, ...]:
    tau = np.broadcast_to(TIMES[:, None, None], (3, len(TIMES), 2, 3)).copy()
    return free_flight((tau, tau[..., 0].copy()), motion, touched(), GRAVITY)


@pytest.mark.parametrize("frame", range(len(TIMES)))
def test_a_sphere_falls_on_a_parabola_of_its_side_of_contact(
    motion: tuple[np.ndarray, np.ndarray, np.ndarray], frame: int
) -> None:
    tau = TIMES[frame]
    side = int(tau > 0)
    place, velocity, _ = (part[:, :, side] for part in motion)
    expected = place + velocity * tau
    expected[..., 0] += GRAVITY * tau**2 / 2
    position, own_velocity, *_ = flown(motion)
    np.testing.assert_allclose(position[:, frame], expected, atol=1e-15)
    np.testing.assert_array_equal(own_velocity[:, frame], velocity)


@pytest.mark.parametrize("frame", range(len(TIMES)))
def test_a_sphere_turns_about_the_axis_of_its_spin(
    motion: tuple[np.ndarray, np.ndarray, np.ndarray], frame: int
) -> None:
    tau = TIMES[frame]
    side = int(tau > 0)
    vector = motion[2][:, :, side] * tau
    turn = Rotation.from_rotvec(vector.reshape(-1, 3)).as_matrix().reshape(3, 2, 3, 3)
    *_, spin, rotation, jacobian, turned = flown(motion)
    np.testing.assert_array_equal(spin[:, frame], motion[2][:, :, side])
    np.testing.assert_allclose(turned[:, frame], turn, atol=2e-15)
    np.testing.assert_allclose(rotation[:, frame], turn @ touched()[:, :, side], atol=2e-15)
    np.testing.assert_allclose(jacobian[:, frame], exponential(vector)[1], atol=2e-15)


def test_the_left_jacobian_is_what_differences_of_rotations_say(
    motion: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> None:
    tau, step = TIMES[-1], 1e-4
    jacobian = flown(motion)[4][:, -1]
    here = Rotation.from_rotvec((motion[2][:, :, 1] * tau).reshape(-1, 3))
    for axis in range(3):
        sides = []
        for way in (step, -step):
            moved = (motion[2][:, :, 1] * tau).reshape(-1, 3)
            moved[:, axis] += way
            sides.append((Rotation.from_rotvec(moved) * here.inv()).as_rotvec())
        slope = (sides[0] - sides[1]) / (2 * step)
        np.testing.assert_allclose(jacobian.reshape(-1, 3, 3)[..., axis], slope, atol=1e-8)
