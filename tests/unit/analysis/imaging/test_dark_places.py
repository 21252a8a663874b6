"""Dark places on drawn balls, against where their markers were drawn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from analysis.imaging.marker.dark_places import find_dark_places
from analysis.imaging.marker.markers import SeenDisc
from analysis.imaging.outlines import Outline
from analysis.imaging.shells import Circle
from analysis.imaging.views import View, ViewGeometry

Floats = NDArray[np.float64]

SIZE, PLACE, ALPHA, NOISE, FINE = 96, (47.3, 48.6), 0.16, 2.0, 5
FRONT = ViewGeometry(View.FRONT, (0, SIZE), (0.0, 0.0))
LAMP = np.array([-0.4, -0.7, 0.59])
PATTERN = np.array(
    [[0.0, 0.0, 1.0], [0.55, 0.2, 0.81], [-0.5, 0.35, 0.79], [0.1, -0.6, 0.79], [-0.3, -0.4, 0.87]]
)


def ball(radius: float, gloss: float, side: float, background: float) -> Floats:
    """Return a marked ball in side light, with a highlight that markers do not swallow."""
    grid = (np.arange(SIZE * FINE) + 0.5) / FINE - 0.5
    u, v = np.meshgrid((grid - PLACE[0]) / radius, (grid - PLACE[1]) / radius, indexing="ij")
    inside = u**2 + v**2 < 1.0
    normal = np.stack([u, v, np.sqrt(np.maximum(1.0 - u**2 - v**2, 0.0))], axis=-1)
    facing = normal @ LAMP
    light = 30.0 + 90.0 * ((1.0 - side) * normal[..., 2] + side * np.maximum(facing, 0.0))
    markers = PATTERN / np.linalg.norm(PATTERN, axis=1)[:, None]
    covered = ((normal @ markers.T) > np.cos(ALPHA)).any(axis=-1)
    mirrored = np.maximum(2.0 * facing * normal[..., 2] - LAMP[2], 0.0)
    scene = np.where(covered, 0.3 * light, light) + gloss * mirrored**60
    whole = np.where(inside, scene, background)
    seen = gaussian_filter(whole, 0.85 * FINE).reshape(SIZE, FINE, SIZE, FINE)
    return np.asarray(seen.mean(axis=(1, 3)))


def found_in(picture: Floats, radius: float, seed: int = 1) -> Floats:
    """Return the directions of the dark places, shape (places, 3)."""
    noisy = picture + NOISE * np.random.default_rng(seed).normal(size=picture.shape)
    frame = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    outline = Outline(Circle(*PLACE, radius, np.zeros((3, 3))), 1.0, np.zeros((0, 2)))
    return find_dark_places(frame, [SeenDisc(outline, radius, FRONT)], noise=NOISE)[0].directions


def nearest(directions: Floats, others: Floats) -> Floats:
    """Return for each direction the angle to the nearest of the others, radians."""
    return np.asarray(np.arccos(np.clip(directions @ others.T, -1.0, 1.0)).min(axis=1))


TRUE = PATTERN / np.linalg.norm(PATTERN, axis=1)[:, None]


@settings(deadline=None, max_examples=20)
@given(
    radius=st.floats(18.0, 40.0),
    gloss=st.floats(0.0, 300.0),
    side=st.floats(0.0, 0.8),
    background=st.sampled_from([20.0, 60.0, 200.0]),
)
def test_every_place_is_a_marker_whatever_the_light(
    radius: float, gloss: float, side: float, background: float
) -> None:
    found = found_in(ball(radius, gloss, side, background), radius)
    assert len(found) >= 3
    assert nearest(found, TRUE).max() < 0.12


@pytest.mark.parametrize("radius", [13.0, 20.0, 36.0])
def test_markers_are_found_from_two_pixels_in_radius_on(radius: float) -> None:
    found = found_in(ball(radius, 0.0, 0.2, 40.0), radius)
    assert nearest(TRUE, found).max() < 0.08


def test_a_cast_shadow_is_no_marker() -> None:
    rows, columns = np.mgrid[:SIZE, :SIZE]
    edge = 1.0 / (1.0 + np.exp((rows + 0.6 * columns - 80.0) / 0.8))
    picture = ball(24.0, 0.0, 0.1, 40.0) * (0.25 + 0.75 * edge)
    found = found_in(picture, 24.0)
    assert nearest(found, TRUE).max() < 0.12


def test_what_lies_in_another_disc_is_left_out() -> None:
    picture = ball(24.0, 0.0, 0.1, 40.0)
    frame = np.rint(picture).astype(np.uint8)
    outline = Outline(Circle(*PLACE, 24.0, np.zeros((3, 3))), 1.0, np.zeros((0, 2)))
    other = (PLACE[0] + 24.0, PLACE[1] + 5.0, 24.0)
    found, _ = find_dark_places(frame, [SeenDisc(outline, 24.0, FRONT)], [other], noise=NOISE)
    places = found.ellipses[:, :2]
    assert len(places) == len(PATTERN) - 1
    assert (np.hypot(*(places - other[:2]).T) > 24.0).all()


def test_a_disc_out_of_the_frame_has_none() -> None:
    frame = np.full((SIZE, SIZE), 40, dtype=np.uint8)
    outline = Outline(Circle(-80.0, 300.0, 24.0, np.zeros((3, 3))), 1.0, np.zeros((0, 2)))
    found, ends = find_dark_places(frame, [SeenDisc(outline, 24.0, FRONT)], noise=NOISE)
    assert len(found) == 0
    assert ends.tolist() == [0]
