"""Covers of markers against caps counted point by point."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.photometric.render.contour import ALPHA as BY_ALPHA
from analysis.photometric.render.contour import GROWTHS, LAYERS, add_cover
from analysis.photometric.render.contour import RADIUS as BY_RADIUS
from analysis.photometric.render.pixel_rows import roughness

SIZE, RADIUS, ALPHA, SUBPIXELS = 61, 20.0, 0.16, 9
BLUR = 0.85
PLACE = (30.0, 30.0, RADIUS)


def cover(place, marker, alpha=ALPHA, sigma=BLUR, layers=LAYERS):
    canvas = np.zeros((SIZE, layers, SIZE))
    add_cover(canvas, (0, 0), place, np.asarray(marker), (alpha, sigma))
    return canvas.transpose(1, 0, 2)


def counted(marker, alpha=ALPHA):
    """Share of each pixel's sub-pixels on the visible cap, blurred by the lens alone."""
    fine = ((np.arange(SIZE * SUBPIXELS) + 0.5) / SUBPIXELS - 0.5 - 30.0) / RADIUS
    u, v = np.meshgrid(fine, fine, indexing="ij")
    height = np.sqrt(np.clip(1 - u**2 - v**2, 0, None))
    on = (u**2 + v**2 < 1) & (u * marker[0] + v * marker[1] + height * marker[2] > np.cos(alpha))
    soft = cv2.GaussianBlur(on.astype(float), (0, 0), BLUR * SUBPIXELS)
    return soft.reshape(SIZE, SUBPIXELS, SIZE, SUBPIXELS).mean(axis=(1, 3))


def direction(height, azimuth):
    flat = np.sqrt(1 - height**2)
    return np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), height])


@pytest.mark.parametrize("height", [1.0, 0.9, 0.5, 0.2, 0.1, 0.0, -0.1])
def test_a_cover_is_the_blurred_share_of_the_pixel(height):
    marker = direction(height, 0.7)
    wide = np.hypot(BLUR, 12**-0.5)
    assert np.abs(cover(PLACE, marker, sigma=wide)[0] - counted(marker)).max() < 0.008


def test_a_marker_on_the_far_side_covers_nothing():
    assert not cover(PLACE, [0.0, 0.0, -1.0]).any()


@settings(deadline=None, max_examples=30)
@given(height=st.floats(0.2, 0.95), azimuth=st.floats(0.0, 6.28))
def test_a_whole_marker_covers_its_projected_area(height, azimuth):
    area = np.pi * (RADIUS * np.sin(ALPHA)) ** 2 * height
    assert cover(PLACE, direction(height, azimuth))[0].sum() == pytest.approx(area, rel=1e-3)


@pytest.mark.parametrize("height", [0.95, 0.6, 0.25])
def test_layers_are_the_derivatives_of_the_cover(height):
    marker, step = direction(height, 2.1), 5e-3
    whole = cover(PLACE, marker)
    for axis in (0, 1):
        near, far = list(PLACE), list(PLACE)
        near[axis] -= step
        far[axis] += step
        slope = (cover(tuple(far), marker)[0] - cover(tuple(near), marker)[0]) / (2 * step)
        assert np.abs(slope - whole[1 + axis]).max() < 2e-3 * np.abs(slope).max()
    for axis in range(3):
        turn = np.cross(np.eye(3)[axis], marker) * step * 0.05
        slope = (cover(PLACE, marker + turn)[0] - cover(PLACE, marker - turn)[0]) / (0.1 * step)
        assert np.abs(slope - whole[3 + axis]).max() < 2e-3 * np.abs(whole[3:]).max()


@pytest.mark.parametrize(
    ("height", "within"), [(0.95, 5e-3), (0.6, 5e-3), (0.25, 5e-3), (0.1, 0.06)]
)
def test_deeper_layers_are_the_derivatives_to_the_sizes_of_cap_and_sphere(height, within):
    marker, step = direction(height, 2.1), 1e-3
    layers = cover(PLACE, marker, layers=LAYERS + GROWTHS)
    assert layers[:LAYERS] == pytest.approx(cover(PLACE, marker), abs=1e-12)
    less, more = (cover(PLACE, marker, alpha=ALPHA + side * step)[0] for side in (-1, 1))
    slope = (more - less) / (2 * step)
    assert np.abs(slope - layers[BY_ALPHA]).max() < within * np.abs(slope).max()
    less, more = (cover((*PLACE[:2], RADIUS * np.exp(side * step)), marker)[0] for side in (-1, 1))
    slope = (more - less) / (2 * step)
    assert np.abs(slope - layers[BY_RADIUS]).max() < within * np.abs(slope).max()


@pytest.mark.parametrize("height", [0.95, 0.25])
def test_a_cover_grows_smooth_as_heat_spreads(height):
    marker, step = direction(height, 2.1), 1e-3
    canvas = np.ascontiguousarray(cover(PLACE, marker).transpose(1, 0, 2))
    less, more = (cover(PLACE, marker, sigma=BLUR + side * step)[0] for side in (-1, 1))
    slope = (more - less) / (2 * step)
    rough = [[roughness.py_func(canvas, i, j) for j in range(SIZE)] for i in range(SIZE)]
    assert np.abs(BLUR * np.array(rough) - slope).max() < 0.05 * np.abs(slope).max()


def test_a_marker_beyond_the_canvas_is_left_out():
    canvas = np.zeros((10, LAYERS, 10))
    add_cover(canvas, (100, 100), PLACE, np.array([0.0, 0.0, 1.0]), (ALPHA, BLUR))
    assert not canvas.any()
