"""Blurred harmonics against pictures blurred by brute force."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from analysis.photometric.render.shading import (
    DISC,
    HARMONICS,
    RADIALS,
    STEPS_PER_RADIUS,
    blurred_profiles,
    template,
)

RADIUS, SIGMA = 200.0, 0.045


def blurred_picture(radial):
    """The function on a grid of 200 pixels a radius, its profile along theta = 0."""
    half = 300
    y, x = np.mgrid[-half : half + 1, -half : half + 1] / RADIUS
    rho = np.hypot(x, y)
    height = np.sqrt(np.clip(1 - rho**2, 0, None))
    angle = np.cos(radial.angular * np.arctan2(y, x))
    # A pixel on the outline counts by the part of it that lies inside.
    inside = np.clip((1 - rho) * RADIUS + 0.5, 0, 1)
    picture = inside * rho**radial.power * height**radial.height * angle
    size = 2 * int(6 * SIGMA * RADIUS) + 1
    return cv2.GaussianBlur(picture, (size, size), SIGMA * RADIUS)[half, half:]


@pytest.mark.parametrize("index", range(len(RADIALS)), ids=lambda i: str(RADIALS[i]))
def test_profiles_are_the_blurred_functions(index):
    drawn = blurred_picture(RADIALS[index])
    values = blurred_profiles(SIGMA).values[:, index]
    at = np.arange(len(drawn)) / RADIUS * STEPS_PER_RADIUS
    mine = np.interp(at, np.arange(len(values)), values, right=0.0)
    assert np.abs(mine - drawn).max() < 2e-3


def test_an_even_shading_is_the_disc():
    coefficients = np.zeros(len(HARMONICS))
    coefficients[0] = 7.0
    table = template(blurred_profiles(SIGMA), coefficients)
    assert np.allclose(table[:, 0], 7.0 * table[:, DISC])
    assert table[0, DISC] == pytest.approx(1.0, abs=1e-6)
    assert table[STEPS_PER_RADIUS, DISC] == pytest.approx(0.5, abs=0.02)
