"""Covers of markers against caps counted point by point."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.photometric.contour import LAYERS, add_cover

SIZE, RADIUS, ALPHA, SUBPIXELS = 61, 20.0, 0.16, 9
BLUR = 0.85
PLACE = (30.0, 30.0, RADIUS)


def cover(place, marker, alpha=ALPHA, sigma=BLUR):
    canvas = np.zeros((SIZE, LAYERS, SIZE))
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


def test_a_marker_beyond_the_canvas_is_left_out():
    canvas = np.zeros((10, LAYERS, 10))
    add_cover(canvas, (100, 100), PLACE, np.array([0.0, 0.0, 1.0]), (ALPHA, BLUR))
    assert not canvas.any()
