"""Camera effects against pictures: points are drawn, the picture is changed, and read again."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.effects.camera import (
    camera_roll,
    mirror_angle,
    perspective,
    pixel_aspect,
    radial_distortion,
)
from analysis.effects.effect import CameraEffect
from analysis.setup import CameraSetup

SCALE = 1574.8
FRONT, TOP = np.array([132.0, 120.0]), np.array([46.0, 120.0])
CAMERA = CameraSetup(1000.0, 192, 240, (88, 192), (0, 88), SCALE, tuple(FRONT), tuple(TOP))
MIDDLE = np.array([95.5, 119.5])

places = st.tuples(*[st.floats(-0.03, 0.03)] * 3).map(np.array)
small = st.floats(-0.03, 0.03)


def drawn(point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where the two views show a point, (row, column): X down, Y right, Z up in the mirror."""
    x, y, z = point
    return FRONT + SCALE * np.array([x, y]), TOP + SCALE * np.array([-z, y])


def read(front: np.ndarray, top: np.ndarray) -> np.ndarray:
    """X and Y from the front view, Z from the rows of the top view."""
    row, column = (front - FRONT) / SCALE
    return np.array([row, column, -(top - TOP)[0] / SCALE])


def seen(effect: CameraEffect, point: np.ndarray, value: float) -> np.ndarray:
    return effect.appear(point, CAMERA, np.array([value]))


@given(first=places, second=places, angle=small)
def test_roll_turns_the_picture_as_a_whole(
    first: np.ndarray, second: np.ndarray, angle: float
) -> None:
    # About the frame's centre, which shifts each coordinate by a constant: compare differences.
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])

    def turned(point: np.ndarray) -> np.ndarray:
        return read(*(MIDDLE + turn @ (image - MIDDLE) for image in drawn(point)))

    apparent = seen(camera_roll.EFFECT, second, angle) - seen(camera_roll.EFFECT, first, angle)
    np.testing.assert_allclose(apparent, turned(second) - turned(first), atol=1e-14)


def test_roll_is_no_rotation_of_space() -> None:
    # Spheres a diameter apart along Y: one seems higher in both views, so nearer and higher.
    apart = seen(camera_roll.EFFECT, np.array([0.0, 0.0254, 0.0]), 0.01)
    assert apart[0] == pytest.approx(-0.254e-3, rel=1e-4)
    assert apart[2] == pytest.approx(0.254e-3, rel=1e-4)


@given(first=places, second=places, share=small)
def test_aspect_stretches_the_rows_of_both_views(
    first: np.ndarray, second: np.ndarray, share: float
) -> None:
    def stretched(point: np.ndarray) -> np.ndarray:
        return read(*(image * [1 + share, 1.0] for image in drawn(point)))

    apparent = seen(pixel_aspect.EFFECT, second, share) - seen(pixel_aspect.EFFECT, first, share)
    np.testing.assert_allclose(apparent, stretched(second) - stretched(first), atol=1e-14)


@given(first=places, second=places, angle=small)
def test_a_turned_mirror_shows_what_reflection_in_its_plane_shows(
    first: np.ndarray, second: np.ndarray, angle: float
) -> None:
    from_x = np.pi / 4 + angle
    normal = np.array([np.cos(from_x), 0.0, np.sin(from_x)])
    plane = -0.1 * normal

    def mirrored(point: np.ndarray) -> float:
        image = point - 2 * ((point - plane) @ normal) * normal
        return float(-image[0])

    apparent = seen(mirror_angle.EFFECT, second, angle) - seen(mirror_angle.EFFECT, first, angle)
    assert apparent[2] == pytest.approx(mirrored(second) - mirrored(first), abs=1e-14)
    np.testing.assert_array_equal(apparent[:2], second[:2] - first[:2])


def test_one_degree_of_the_mirror_takes_3_5_per_cent_of_height_for_depth() -> None:
    depth = seen(mirror_angle.EFFECT, np.array([1.0, 0.0, 0.0]), np.radians(1.0))[2]
    assert depth == pytest.approx(-0.035, abs=2e-4)


@given(point=places, distance=st.floats(0.5, 5.0))
def test_perspective_is_a_pinhole_that_looks_squarely_at_each_view(
    point: np.ndarray, distance: float
) -> None:
    # The ray from the pinhole through the point meets the plane through the origin there.
    front_eye, top_eye = np.array([0.0, 0.0, distance]), np.array([-distance, 0.0, 0.0])

    def pierced(eye: np.ndarray, axis: int) -> np.ndarray:
        along = point - eye
        return eye - along * eye[axis] / along[axis]

    apparent = seen(perspective.EFFECT, point, 1 / distance)
    np.testing.assert_allclose(apparent[:2], pierced(front_eye, 2)[:2], rtol=1e-12, atol=1e-16)
    assert apparent[2] == pytest.approx(pierced(top_eye, 0)[2], rel=1e-12, abs=1e-16)


def test_5_mm_nearer_at_a_metre_is_half_a_per_cent_larger() -> None:
    near = seen(perspective.EFFECT, np.array([0.0, 0.01, 0.005]), 1.0)
    assert near[1] / 0.01 - 1 == pytest.approx(0.005, abs=3e-5)


def test_a_corner_of_the_frame_lies_too_far_out_by_k1() -> None:
    half = np.array([96.0, 120.0])
    corner = (MIDDLE + half - FRONT) / SCALE
    point = np.array([*corner, 0.0])
    moved = (seen(radial_distortion.EFFECT, point, 0.02) - point)[:2] * SCALE
    np.testing.assert_allclose(moved, 0.02 * half, rtol=1e-12)


def test_the_middle_of_the_frame_is_not_distorted() -> None:
    point = np.array([*((MIDDLE - FRONT) / SCALE), (TOP - MIDDLE)[0] / SCALE])
    np.testing.assert_allclose(
        seen(radial_distortion.EFFECT, point, 0.05)[:2], point[:2], atol=1e-15
    )


@given(point=places, k1=st.floats(-0.05, 0.05))
def test_distortion_moves_the_image_points_of_both_views(point: np.ndarray, k1: float) -> None:
    def distorted(image: np.ndarray) -> np.ndarray:
        offset = image - MIDDLE
        radius = np.hypot(*offset) / np.hypot(96, 120)
        return MIDDLE + offset * (1 + k1 * radius**2)

    expected = read(*(distorted(image) for image in drawn(point)))
    np.testing.assert_allclose(
        seen(radial_distortion.EFFECT, point, k1), expected, rtol=1e-12, atol=1e-15
    )


def test_distortion_leaves_depth_alone_where_no_mirror_shows_it() -> None:
    point = np.array([0.01, 0.02, 0.003])
    single = replace(CAMERA, top_view_rows=None, top_origin_px=None)
    moved = radial_distortion.EFFECT.appear(point, single, np.array([0.05]))
    assert moved[2] == point[2]
    assert moved[1] != point[1]


def test_distortion_waits_for_a_scale_before_it_moves_anything() -> None:
    point = np.array([0.01, 0.02, 0.003])
    unscaled = replace(CAMERA, scale_px_per_m=None)
    moved = radial_distortion.EFFECT.appear(point, unscaled, np.array([0.05]))
    np.testing.assert_array_equal(moved, point)


@pytest.mark.parametrize(
    "module", [camera_roll, mirror_angle, perspective, pixel_aspect, radial_distortion]
)
def test_many_points_at_once_are_seen_as_one_by_one(module: object) -> None:
    effect: CameraEffect = module.EFFECT  # type: ignore[attr-defined]
    points = np.random.default_rng(1).normal(0, 0.02, (3, 4, 2, 3))
    before = points.copy()
    together = seen(effect, points, 0.01)
    np.testing.assert_array_equal(points, before)
    for index in np.ndindex(3, 4, 2):
        np.testing.assert_allclose(together[index], seen(effect, points[index], 0.01), rtol=1e-14)
