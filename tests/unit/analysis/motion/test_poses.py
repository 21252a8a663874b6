import math

import numpy as np
import pytest

from analysis.imaging.outlines import Outline
from analysis.imaging.shells import Circle
from analysis.imaging.tracks import Track
from analysis.imaging.views import View, ViewGeometry
from analysis.motion.poses import LEAST_SIGMA_PX, centre_sigma, centres

FRONT = ViewGeometry(View.FRONT, (88, 192), (132.0, 120.0))
TOP = ViewGeometry(View.TOP, (0, 88), (46.0, 120.0))
SCALES = {View.FRONT: 1574.8, View.TOP: 1500.0}


def outline(row: float, column: float, variance: float = 0.0, points: int = 100) -> Outline:
    covariance = np.diag([variance, 4 * variance, variance])
    return Outline(Circle(row, column, 20.0, covariance), 1.0, np.zeros((points, 2)))


def tracks(front: dict[int, Outline], top: dict[int, Outline] | None = None) -> dict[View, Track]:
    found = {View.FRONT: Track(View.FRONT, front)}
    return found if top is None else found | {View.TOP: Track(View.TOP, top)}


def test_x_and_y_come_from_the_front_view_and_z_from_the_top_view() -> None:
    point = np.array([0.011, -0.024, 0.005])
    front = outline(132.0 + 1574.8 * point[0], 120.0 + 1574.8 * point[1])
    top = outline(46.0 - 1500.0 * point[2], 120.0 + 1500.0 * point[1])
    found = centres(tracks({3: front}, {3: top}), (FRONT, TOP), SCALES, 1.2)
    assert found.frames.tolist() == [3]
    np.testing.assert_allclose(found.position[0], point, atol=1e-12)
    np.testing.assert_allclose(found.sigma[0] * [1574.8, 1574.8, 1500.0], LEAST_SIGMA_PX)


def test_a_frame_without_the_front_view_is_left_out_and_one_without_the_top_view_lacks_z() -> None:
    front = {k: outline(130.0, 100.0) for k in (0, 1, 2, 4)}
    top = {k: outline(45.0, 100.0) for k in (1, 2, 3, 4)}
    found = centres(tracks(front, top), (FRONT, TOP), SCALES, 1.2)
    assert found.frames.tolist() == [0, 1, 2, 4]
    assert np.isinf(found.sigma[:, 2]).tolist() == [True, False, False, False]
    assert np.isnan(found.position[:, 2]).tolist() == [True, False, False, False]
    assert np.isfinite(found.position[:, :2]).all()


def test_without_a_top_view_z_is_constant() -> None:
    front = {k: outline(130.0 + k, 100.0) for k in range(4)}
    found = centres(tracks(front), (FRONT,), SCALES, 1.2)
    assert found.frames.tolist() == [0, 1, 2, 3]
    assert not found.position[:, 2].any()
    assert (found.sigma > 0).all()


@pytest.mark.parametrize("points", [20, 400])
def test_edge_points_within_the_filters_reach_repeat_each_other(points: int) -> None:
    found = centre_sigma(outline(0.0, 0.0, 1e-4, points), 1.2)
    rim = 2 * math.pi * 20.0
    repeats = max(1.0, points * 2 * math.sqrt(math.pi) * 1.2 / rim)
    expected = np.sqrt(np.array([1e-4, 4e-4]) * repeats + LEAST_SIGMA_PX**2)
    np.testing.assert_allclose(found, expected)
