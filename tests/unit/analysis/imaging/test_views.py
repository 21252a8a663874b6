import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.imaging.views import View, ViewGeometry, view_geometries
from analysis.setup import CameraSetup

FRONT = ViewGeometry(View.FRONT, (88, 192), (132.0, 120.0))
TOP = ViewGeometry(View.TOP, (0, 88), (46.0, 120.0))


def pixel_of(view: ViewGeometry, point: np.ndarray, scale: float) -> tuple[float, float]:
    """Where the exchange format says that the camera sees a point (x, y, z)."""
    x, y, z = point
    if view.view is View.FRONT:
        return view.origin[0] + scale * x, view.origin[1] + scale * y
    return view.origin[0] - scale * z, view.origin[1] + scale * y


@pytest.mark.parametrize("view", [FRONT, TOP])
def test_a_point_of_a_sphere_lies_where_the_exchange_format_puts_it(view: ViewGeometry) -> None:
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    offsets = view.offsets(directions)
    for direction, (row, column, _) in zip(directions, offsets, strict=True):
        expected = pixel_of(view, direction, 20.0)
        assert (20 * row + view.origin[0], 20 * column + view.origin[1]) == pytest.approx(expected)


def test_the_front_view_sees_the_near_side_and_the_top_view_the_upper_side() -> None:
    toward_the_camera, up = np.array([0.0, 0.0, 1.0]), np.array([-1.0, 0.0, 0.0])
    assert FRONT.offsets(toward_the_camera)[2] == 1.0
    assert FRONT.offsets(up)[2] == 0.0
    assert TOP.offsets(up)[2] == 1.0
    # A point nearer the camera stands higher in the top view.
    assert TOP.offsets(toward_the_camera)[0] == -1.0


@given(
    rho=st.floats(0.0, 0.999), angle=st.floats(0, 2 * math.pi), view=st.sampled_from([FRONT, TOP])
)
def test_lifting_and_projecting_undo_each_other(
    rho: float, angle: float, view: ViewGeometry
) -> None:
    row, column = np.array([rho * math.cos(angle)]), np.array([rho * math.sin(angle)])
    direction = view.direction(row, column)
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    depth = math.sqrt(1 - rho**2)
    assert view.offsets(direction)[0] == pytest.approx((row[0], column[0], depth), abs=1e-12)


@given(x=st.floats(-1, 1), y=st.floats(-1, 1), z=st.floats(-1, 1))
def test_a_visible_direction_comes_back_from_its_image(x: float, y: float, z: float) -> None:
    length = math.sqrt(x**2 + y**2 + z**2)
    if length < 0.1:
        return
    direction = np.array([x, y, z]) / length
    for view in (FRONT, TOP):
        row, column, depth = view.offsets(direction)
        if depth > 0.05:
            lifted = view.direction(np.array([row]), np.array([column]))[0]
            np.testing.assert_allclose(lifted, direction, atol=1e-9)


def test_views_take_their_origin_from_the_set_up_or_the_middle_of_their_rows() -> None:
    camera = CameraSetup(1000.0, 192, 240, (88, 192), (0, 88), front_origin_px=(132.0, 120.0))
    front, top = view_geometries(camera)
    assert (front.view, front.rows, front.origin) == (View.FRONT, (88, 192), (132.0, 120.0))
    assert (top.view, top.rows, top.origin) == (View.TOP, (0, 88), (43.5, 119.5))
    (alone,) = view_geometries(CameraSetup(1000.0, 192, 240))
    assert (alone.view, alone.origin) == (View.FRONT, (95.5, 119.5))
