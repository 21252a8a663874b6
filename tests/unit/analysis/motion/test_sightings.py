"""Markers directed anew from other outlines, against directions that were projected by hand."""

import math

import numpy as np
import pytest
from found import At, discs_at

from analysis.imaging.marker.markers import FilmMarkers, Markers, film_markers
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


def again_from(view: View, seen: dict[int, Markers], frames: tuple[int, ...]) -> FilmMarkers:
    """Direct markers anew from outlines of one view in some of five frames."""
    discs = discs_at(5, {view: {k: At(*CENTRES[view], RADIUS) for k in frames}})
    return lifted_again(film_markers(seen), discs, 0, {view: (RADIUS, RADIUS)})


@pytest.mark.parametrize("view", list(View))
def test_markers_are_directed_from_the_middles_of_the_new_outlines(view: View) -> None:
    # What faces the camera has X upward as its depth in the top view.
    directions = TRUE if view is View.FRONT else TRUE[:, [2, 1, 0]] * [-1.0, 1.0, 1.0]
    again = again_from(view, {4: shown(view, directions)}, (4,)).get(4)
    assert again is not None
    np.testing.assert_allclose(again.directions, directions, atol=1e-12)
    np.testing.assert_allclose(again.facing, TRUE[:, 2], atol=1e-12)


def test_markers_without_an_outline_are_left_out_and_other_frames_keep_theirs() -> None:
    again = again_from(View.FRONT, {k: shown(View.FRONT, TRUE[: k + 1]) for k in range(3)}, (0, 2))
    assert again.ends.tolist() == [1, 1, 4]
    assert again.get(1) is not None
    assert again.get(3) is None
    np.testing.assert_allclose(again.every.directions[1:], TRUE, atol=1e-12)


def test_a_marker_that_comes_too_near_to_the_limb_is_left_out() -> None:
    limb = np.array([[0.0, 0.9, math.sqrt(1 - 0.81)]])
    assert len(again_from(View.FRONT, {0: shown(View.FRONT, limb)}, (0,)).every) == 0


def test_a_sphere_that_is_never_seen_has_none() -> None:
    assert len(again_from(View.FRONT, {}, ()).frames) == 0
