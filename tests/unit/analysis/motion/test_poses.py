import math

import numpy as np
import pytest
from found import At, discs_at

from analysis.imaging.views import View, ViewGeometry
from analysis.motion.poses import LEAST_SIGMA_PX, Centres, centre_sigmas, centres

FRONT = ViewGeometry(View.FRONT, (88, 192), (132.0, 120.0))
TOP = ViewGeometry(View.TOP, (0, 88), (46.0, 120.0))
SCALES = {View.FRONT: 1574.8, View.TOP: 1500.0}


def placed(front: dict[int, At], top: dict[int, At] | None = None) -> Centres:
    seen = {View.FRONT: front} if top is None else {View.FRONT: front, View.TOP: top}
    views = (FRONT,) if top is None else (FRONT, TOP)
    return centres(discs_at(5, seen), 0, views, SCALES, (1.2, LEAST_SIGMA_PX))


def test_x_and_y_come_from_the_front_view_and_z_from_the_top_view() -> None:
    point = np.array([0.011, -0.024, 0.005])
    front = At(132.0 + 1574.8 * point[0], 120.0 + 1574.8 * point[1])
    top = At(46.0 - 1500.0 * point[2], 120.0 + 1500.0 * point[1])
    found = placed({3: front}, {3: top})
    assert found.frames.tolist() == [3]
    np.testing.assert_allclose(found.position[0], point, atol=1e-12)
    np.testing.assert_allclose(found.sigma[0] * [1574.8, 1574.8, 1500.0], LEAST_SIGMA_PX)


def test_a_frame_without_the_front_view_is_left_out_and_one_without_the_top_view_lacks_z() -> None:
    front = {k: At(130.0, 100.0) for k in (0, 1, 2, 4)}
    top = {k: At(45.0, 100.0) for k in (1, 2, 3, 4)}
    found = placed(front, top)
    assert found.frames.tolist() == [0, 1, 2, 4]
    assert np.isinf(found.sigma[:, 2]).tolist() == [True, False, False, False]
    assert np.isnan(found.position[:, 2]).tolist() == [True, False, False, False]
    assert np.isfinite(found.position[:, :2]).all()


def test_without_a_top_view_z_is_constant() -> None:
    front = {k: At(130.0 + k, 100.0) for k in range(4)}
    found = placed(front)
    assert found.frames.tolist() == [0, 1, 2, 3]
    assert not found.position[:, 2].any()
    assert (found.sigma > 0).all()


@pytest.mark.parametrize("points", [20, 400])
def test_edge_points_within_the_filters_reach_repeat_each_other(points: int) -> None:
    seen = {2: At(0.0, 0.0, variance=(1e-4, 4e-4, 1e-4), points=points)}
    found = centre_sigmas(discs_at(3, {View.FRONT: seen}), (0, 0), 1.2)[2]
    rim = 2 * math.pi * 20.0
    repeats = max(1.0, points * 2 * math.sqrt(math.pi) * 1.2 / rim)
    expected = np.sqrt(np.array([1e-4, 4e-4]) * repeats + LEAST_SIGMA_PX**2)
    np.testing.assert_allclose(found, expected)
