"""Markers directed anew from other outlines, against directions that were projected by hand."""

import math

import numpy as np
import pytest

from analysis.imaging.markers import Markers
from analysis.imaging.outlines import Outline
from analysis.imaging.shells import Circle
from analysis.imaging.tracks import Track
from analysis.imaging.views import View
from analysis.motion.sightings import lifted_again

RADIUS, ALPHA = 20.0, 0.16
CENTRES = {View.FRONT: (90.0, 60.0), View.TOP: (30.0, 61.0)}
TRUE = np.array([[0.3, -0.2, 0.0], [-0.4, 0.5, 0.0], [0.0, 0.1, 0.0]])
TRUE[:, 2] = np.sqrt(1.0 - (TRUE**2).sum(axis=1))


def shown(view: View, directions: np.ndarray) -> Markers:
    """Project caps of radius ALPHA whose directions from the first outline would be wrong."""
    x, y, z = directions.T
    row, column = (x, y) if view is View.FRONT else (-z, y)
    deep, wide = math.cos(ALPHA) * RADIUS, math.sin(ALPHA) * RADIUS
    flat = np.stack([CENTRES[view][0] + deep * row, CENTRES[view][1] + deep * column], axis=1)
    ellipses = np.hstack([flat, np.tile([wide, wide, 0.0, 0.0], (len(flat), 1))])
    front = np.full(len(flat), view is View.FRONT)
    return Markers(ellipses, np.full((len(flat), 3), np.nan), np.full(len(flat), np.nan), front)


def track(view: View, frames: tuple[int, ...]) -> Track:
    circle = Circle(*CENTRES[view], RADIUS, np.zeros((3, 3)))
    return Track(view, {k: Outline(circle, 1.0, np.zeros((0, 2))) for k in frames})


@pytest.mark.parametrize("view", list(View))
def test_markers_are_directed_from_the_middles_of_the_new_outlines(view: View) -> None:
    # What faces the camera has X upward as its depth in the top view.
    directions = TRUE if view is View.FRONT else TRUE[:, [2, 1, 0]] * [-1.0, 1.0, 1.0]
    again = lifted_again({4: shown(view, directions)}, {view: track(view, (4,))}, {view: RADIUS})
    np.testing.assert_allclose(again[4].directions, directions, atol=1e-12)
    np.testing.assert_allclose(again[4].facing, TRUE[:, 2], atol=1e-12)


def test_markers_without_an_outline_are_left_out_and_other_frames_keep_theirs() -> None:
    seen = {k: shown(View.FRONT, TRUE[: k + 1]) for k in range(3)}
    again = lifted_again(seen, {View.FRONT: track(View.FRONT, (0, 2))}, {View.FRONT: RADIUS})
    assert [len(again[k]) for k in range(3)] == [1, 0, 3]
    np.testing.assert_allclose(again[2].directions, TRUE, atol=1e-12)


def test_a_marker_that_comes_too_near_to_the_limb_is_left_out() -> None:
    limb = np.array([[0.0, 0.9, math.sqrt(1 - 0.81)]])
    tracks = {View.FRONT: track(View.FRONT, (0,))}
    assert len(lifted_again({0: shown(View.FRONT, limb)}, tracks, {View.FRONT: RADIUS})[0]) == 0


def test_a_sphere_that_is_never_seen_has_none() -> None:
    assert lifted_again({}, {View.FRONT: track(View.FRONT, ())}, {View.FRONT: RADIUS}) == {}
