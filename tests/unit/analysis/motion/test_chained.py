import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from turning import CAMERA, LEAST_FACING, body_markers

from analysis.errors import ShotRefusedError
from analysis.imaging.marker.markers import Markers, film_markers, joined
from analysis.imaging.views import View
from analysis.motion.pattern import sightings
from analysis.motion.proximal import orient_by_steps
from analysis.motion.sightings import marker_angle

RADIUS = 20.0
STEP = np.array([0.03, 0.05, -0.04])


def seen_in(view: View, directions: np.ndarray, semi_major: float = 3.2) -> Markers:
    ellipses = np.array([[0.0, 0.0, semi_major, 2.0, 0.0, 0.0]] * len(directions))
    front = np.full(len(directions), view is View.FRONT)
    return Markers(ellipses, directions, directions @ CAMERA, front)


def front_markers(turn: Rotation) -> Markers:
    turned = turn.apply(body_markers())
    return seen_in(View.FRONT, turned[turned @ CAMERA > LEAST_FACING])


def test_steps_from_frame_to_frame_add_up_to_the_whole_turn() -> None:
    turns = [Rotation.from_rotvec(k * STEP) for k in range(8)]
    seen = film_markers({k: front_markers(t) for k, t in enumerate(turns)})
    found = orient_by_steps(seen, RADIUS, "a")
    assert found.frames.tolist() == list(range(8))
    expected = Rotation.concatenate(turns).as_matrix()
    np.testing.assert_allclose(found.rotation, expected, atol=1e-6)
    assert math.isclose(np.linalg.norm(found.pattern[0]), 1.0)


def test_markers_of_the_top_view_take_no_part() -> None:
    turns = [Rotation.from_rotvec(k * STEP) for k in range(6)]
    stray = seen_in(View.TOP, np.array([[-1.0, 0.0, 0.0]]))
    plain = {k: front_markers(t) for k, t in enumerate(turns)}
    mixed = {k: joined([markers, stray]) for k, markers in plain.items()}
    found, expected = (orient_by_steps(film_markers(own), RADIUS, "a") for own in (mixed, plain))
    np.testing.assert_array_equal(found.rotation, expected.rotation)


def test_two_common_markers_are_refused_with_both_frames() -> None:
    turns = [Rotation.from_rotvec(k * STEP) for k in range(6)]
    seen = {k: front_markers(t) for k, t in enumerate(turns)}
    seen[3] = seen[3].where(slice(2))
    with pytest.raises(ShotRefusedError) as refusal:
        orient_by_steps(film_markers(seen), RADIUS, "b")
    assert (refusal.value.step, refusal.value.frame) == ("markers", 3)
    assert "only 2 markers of sphere b in common with frame 2, 3 are needed" in str(refusal.value)


def test_sightings_keep_order_and_facing_and_an_empty_frame_is_empty() -> None:
    markers = front_markers(Rotation.identity())
    directions, facing, ends = sightings(film_markers({0: markers, 1: joined([])}))
    np.testing.assert_array_equal(directions, markers.directions)
    np.testing.assert_array_equal(facing, markers.facing)
    assert ends.tolist() == [len(markers)] * 2


def test_the_marker_angle_is_the_arc_of_its_median_half_width() -> None:
    sizes = joined([seen_in(View.FRONT, CAMERA[None], s) for s in (2.0, 3.2, 9.0)])
    angle = marker_angle(
        (film_markers({0: sizes}), film_markers({})), {View.FRONT: (RADIUS, RADIUS)}
    )
    assert angle == pytest.approx(math.asin(3.2 / 20.0))
    assert marker_angle((film_markers({}), film_markers({})), {View.FRONT: (RADIUS, RADIUS)}) == 0.0
