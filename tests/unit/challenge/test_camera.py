from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from simulators.challenge.camera import OPTICS, apparent
from simulators.challenge.nature import Nature

Floats = NDArray[np.float64]

SCALE = 1574.8
MIDDLE = np.array([(159.5 - 224.0) / SCALE, (199.5 - 200.0) / SCALE])
"""X and Y that the front view shows in the middle of the picture, m."""


def seen(centre: tuple[float, float, float], nature: Nature, time_s: float = 0.0) -> Floats:
    place = np.array(centre).reshape(1, 1, 1, 3)
    return apparent(place, np.array([[time_s]]), nature, OPTICS).reshape(3)


def test_an_honest_camera_shows_things_where_they_are() -> None:
    rng = np.random.default_rng(1)
    centres = rng.uniform(-0.05, 0.05, (5, 4, 2, 3))
    found = apparent(centres, np.zeros((5, 4)), Nature(), OPTICS)
    np.testing.assert_allclose(found, centres, atol=1e-16)


def test_a_wrong_scale_stretches_all_three_axes() -> None:
    found = seen((0.01, -0.02, 0.003), Nature(image_scale=0.005))
    np.testing.assert_allclose(found, 1.005 * np.array([0.01, -0.02, 0.003]), atol=1e-16)


def test_pixels_that_are_too_high_stretch_x_and_z_but_not_y() -> None:
    near, far = (seen((x, 0.02, x / 2), Nature(pixel_aspect=0.01)) for x in (0.0, 0.01))
    np.testing.assert_allclose(far - near, [0.0101, 0.0, 0.00505], atol=1e-15)


def test_a_turned_mirror_mixes_height_into_depth_by_twice_its_angle() -> None:
    found = seen((0.02, 0.01, 0.003), Nature(mirror_rad=0.01))
    expected = 0.003 * np.cos(0.02) - 0.02 * np.sin(0.02)
    np.testing.assert_allclose(found, [0.02, 0.01, expected], atol=1e-15)


def test_a_rolled_camera_turns_each_view_about_the_picture_s_middle() -> None:
    roll = 0.02
    near, far = (seen((0.0, y, 0.0), Nature(roll_rad=roll)) for y in (0.0, 0.03))
    # Along Y both views move along the columns: down in both, which is +X in front and -Z above.
    expected = 0.03 * np.array([-np.sin(roll), np.cos(roll), np.sin(roll)])
    np.testing.assert_allclose(far - near, expected, atol=1e-15)


def test_distortion_spares_the_middle_and_moves_a_corner_by_its_share() -> None:
    nature = Nature(distortion=0.02)
    middle = seen((MIDDLE[0], MIDDLE[1], 0.0), nature)
    np.testing.assert_allclose(middle[:2], MIDDLE, atol=1e-15)
    half = np.array([319.0, 399.0]) / 2 / SCALE
    corner = seen((MIDDLE[0] + half[0], MIDDLE[1] + half[1], 0.0), nature)
    np.testing.assert_allclose(corner[:2] - MIDDLE, 1.02 * half, atol=1e-15)


def test_a_vibration_moves_both_views_down_together() -> None:
    nature = Nature(shake_px=0.2, shake_hz=100.0)
    still, down, back = (seen((0.01, 0.0, 0.0), nature, t) for t in (0.0, 0.0025, 0.005))
    np.testing.assert_allclose(down - still, [0.2 / SCALE, 0.0, -0.2 / SCALE], atol=1e-15)
    np.testing.assert_allclose(back, still, atol=1e-15)


@pytest.mark.parametrize("rows", ["front_rows", "top_rows"])
def test_each_view_holds_its_origin(rows: str) -> None:
    origin = {"front_rows": OPTICS.front_origin_px, "top_rows": OPTICS.top_origin_px}[rows]
    first, end = getattr(OPTICS, rows)
    assert first < origin[0] < end
