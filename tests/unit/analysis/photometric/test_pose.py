"""Poses of drawn spheres, against where they were drawn and against their stated errors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.motion.rotation import rotation_matrix, rotation_vector
from analysis.photometric.render.pose import fit_pose, turned
from tests.unit.analysis.photometric.drawn import (
    sight_of,
    sphere_image,
    spread_markers,
    stance_at,
    with_noise,
)

RADIUS, NOISE = 20.0, 2.0
LIMITS = np.array([40.0, 15.0, 6.0, 6.0])
PATTERN = spread_markers(16, seed=3)


def fitted(image, markers, start, *, radius=RADIUS, noise=NOISE):
    sight = sight_of(image, markers, radius=radius, noise=noise)
    stance = stance_at(*start, radius)
    covariance = np.zeros((6, 6))
    quality = fit_pose(sight, stance, LIMITS, covariance)
    return stance, covariance, quality


def pulls(count, *, place=(31.3, 32.8), spoil=None):
    """Errors over stated errors of row, column and three turns, shape (count, 5)."""
    rows = []
    drawn = sphere_image(place=place, radius=RADIUS, markers=PATTERN)
    for seed in range(count):
        image = with_noise(drawn, NOISE, seed)
        if spoil is not None:
            spoil(image)
        stance, covariance, _ = fitted(image, PATTERN, (place[0] + 0.3, place[1] - 0.2))
        error = [*(stance.centre[:2] - np.array(place) / RADIUS), *rotation_vector(stance.rotation)]
        sigma = np.sqrt(np.diag(covariance))[[0, 1, 3, 4, 5]]
        rows.append(np.array(error) / sigma)
    return np.array(rows)


def test_stated_errors_are_those_of_the_noise():
    spread = np.sqrt((pulls(60) ** 2).mean())
    assert 0.85 < spread < 1.15


def test_a_sphere_half_out_of_view_has_honest_errors():
    drawn = sphere_image(place=(3.0, 32.0), radius=RADIUS, markers=PATTERN)
    _, whole, _ = fitted(
        with_noise(sphere_image(place=(32.0, 32.0), radius=RADIUS, markers=PATTERN), NOISE, 1),
        PATTERN,
        (32.2, 32.2),
    )
    _, half, _ = fitted(with_noise(drawn, NOISE, 1), PATTERN, (3.2, 32.2))
    assert half[0, 0] > 1.5 * whole[0, 0]
    assert np.sqrt((pulls(30, place=(3.0, 32.0)) ** 2).mean()) < 1.3


def dead_row(image):
    image[25] = 0


def highlight(image):
    image[26:30, 28:33] = 255


@pytest.mark.parametrize("spoil", [dead_row, highlight])
def test_spoiled_pixels_do_not_make_a_wrong_pose(spoil):
    assert np.abs(pulls(20, spoil=spoil)).max() < 5.0


def test_without_markers_no_orientation_is_claimed():
    none = np.zeros((0, 3))
    image = with_noise(sphere_image(place=(31.6, 32.4), radius=RADIUS, markers=none), NOISE, 5)
    stance, covariance, _ = fitted(image, none, (31.4, 32.0))
    assert np.hypot(*(stance.centre[:2] * RADIUS - [31.6, 32.4])) < 0.05
    assert np.sqrt(np.diag(covariance)[3:]).min() > 3.0


def test_one_marker_leaves_turns_about_it_open():
    one = np.array([[0.0, 0.0, 1.0]])
    image = with_noise(sphere_image(place=(32.0, 32.0), radius=RADIUS, markers=one), NOISE, 6)
    _, covariance, _ = fitted(image, one, (31.9, 32.1))
    about = np.sqrt(np.diag(covariance)[3:])
    assert about[2] > 3.0
    assert about[:2].max() < np.radians(1.0)


@pytest.mark.parametrize("radius", [6.0, 60.0])
def test_small_and_large_spheres_are_placed_within_their_errors(radius):
    size = int(2 * radius + 24)
    place = (size / 2 + 0.3, size / 2 - 0.4)
    drawn = sphere_image(place=place, radius=radius, markers=PATTERN, size=size)
    image = with_noise(drawn, NOISE, 7)
    stance, covariance, _ = fitted(image, PATTERN, (place[0] + 0.2, place[1]), radius=radius)
    error = stance.centre[:2] - np.array(place) / radius
    assert (np.abs(error) < 4.5 * np.sqrt(np.diag(covariance)[:2])).all()


@settings(deadline=None, max_examples=20)
@given(
    off=st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
    turn=st.tuples(*[st.floats(-0.03, 0.03)] * 3),
)
def test_the_fit_comes_back_from_a_pixel_and_three_degrees(off, turn):
    image = with_noise(sphere_image(place=(32.0, 31.5), radius=RADIUS, markers=PATTERN), NOISE, 8)
    sight = sight_of(image, PATTERN, radius=RADIUS, noise=NOISE)
    stance = stance_at(32.0 + off[0], 31.5 + off[1], RADIUS)
    stance.rotation[:] = rotation_matrix(np.array(turn))
    fit_pose(sight, stance, np.array([60.0] * 5 + [6.0] * 3), np.zeros((6, 6)))
    assert np.hypot(*(stance.centre[:2] * RADIUS - [32.0, 31.5])) < 0.06
    assert np.linalg.norm(rotation_vector(stance.rotation)) < np.radians(0.4)


@given(vector=st.tuples(*[st.floats(-1.0, 1.0)] * 3))
@settings(deadline=None)
def test_turning_is_the_rotation_by_a_vector(vector):
    start = rotation_matrix(np.array([0.3, -0.2, 0.5]))
    assert np.allclose(turned(np.array(vector), start), rotation_matrix(np.array(vector)) @ start)
