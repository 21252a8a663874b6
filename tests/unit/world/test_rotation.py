import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from simulators.world.rotation import matrix, product, random_orientation, turn

Vector = NDArray[np.float64]


def scipys(q: Vector) -> Rotation:
    return Rotation.from_quat(q, scalar_first=True)


@pytest.mark.parametrize("seed", range(5))
def test_the_matrix_is_that_of_scipy(seed: int) -> None:
    q = random_orientation(np.random.default_rng(seed))
    np.testing.assert_allclose(matrix(q), scipys(q).as_matrix(), atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-3, 0.7, 3.0, 7.0])
def test_a_turn_is_about_rig_axes(angle: float) -> None:
    rng = np.random.default_rng(1)
    q = random_orientation(rng)
    vector = angle * random_orientation(rng)[:3]
    expected = (Rotation.from_rotvec(vector) * scipys(q)).as_matrix()
    np.testing.assert_allclose(matrix(turn(vector, q)), expected, atol=1e-13)


def test_a_product_turns_by_the_second_factor_first() -> None:
    rng = np.random.default_rng(2)
    p, q = random_orientation(rng), random_orientation(rng)
    np.testing.assert_allclose(matrix(product(p, q)), matrix(p) @ matrix(q), atol=1e-14)


def test_random_orientations_favour_no_direction() -> None:
    rng = np.random.default_rng(3)
    seen = np.array([matrix(random_orientation(rng))[:, 0] for _ in range(4000)])
    # Each component of a uniform direction has variance 1/3: four standard errors of the mean.
    assert np.all(np.abs(seen.mean(axis=0)) < 4.0 * np.sqrt(1.0 / 3.0 / 4000))
