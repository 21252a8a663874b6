"""The film with the model's outlines: places in both views, and the gap at its true scale."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from rigctl.page.model.story.ghost import of_film, of_places, scene_of
from rigctl.page.shots.films import Film
from rigctl.page.shots.overlay import Overlays

RADII = [12.7, 12.7]
PATHS: dict[str, Any] = {
    "shot": 7,
    "contact_ms": 1.5,
    "radii_mm": RADII,
    "times_ms": [-1.5, -0.5, 0.5],
    "measured": [
        [[0.0, -20.0, 1.0], [5.0, 20.0, -1.0]],
        [[0.0, -13.0, 1.0], None],
        [[0.0, -14.0, 1.0], [5.0, 13.0, -1.0]],
    ],
    "gaps": [
        [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], None],
        [[0.3, -0.4, 1.2], [0.0, 0.0, 0.0]],
    ],
}


def test_places_show_x_down_and_y_across_in_front_and_z_up_from_above() -> None:
    scene = of_places(PATHS)
    a_front, b_front, a_above, b_above = scene.frames[0]["rings"]
    assert b_front[0] - a_front[0] == pytest.approx(40.0)
    assert b_front[1] - a_front[1] == pytest.approx(5.0)
    assert b_above[1] - a_above[1] == pytest.approx(2.0)
    assert a_above[1] + RADII[0] < a_front[1] - RADII[0]
    for ring in (ring for frame in scene.frames for ring in frame["rings"]):
        assert ring[2] <= ring[0] <= scene.width - ring[2]
        assert ring[2] <= ring[1] <= scene.height - ring[2]


def test_the_gap_is_drawn_in_each_view_and_said_in_mm() -> None:
    last = of_places(PATHS).frames[2]
    front, _, above, _ = last["rings"]
    assert above[4:] == [-0.4, -1.2]
    assert front[4:] == [-0.4, 0.3]
    assert last["gap"] == pytest.approx(1.3)
    assert of_places(PATHS).plainest == 2


def test_a_stored_shot_without_frames_is_drawn_from_its_places() -> None:
    films: Any = None
    imported: Any = SimpleNamespace(id="20260131-000001", frames=None)
    assert scene_of(PATHS, imported, films) == scene_of(PATHS, None, films) == of_places(PATHS)


def test_it_begins_where_all_spheres_are_seen() -> None:
    gaps = [PATHS["gaps"][0], [[0.0, 9.0, 0.0], None], PATHS["gaps"][2]]
    assert of_places({**PATHS, "gaps": gaps}).plainest == 2


def test_a_gap_is_drawn_larger_but_stays_below_a_radius() -> None:
    assert of_places(PATHS).times == 3
    small = [[[0.0, 0.01, 0.0], [0.0, 0.0, 0.0]]] * 3
    assert of_places({**PATHS, "gaps": small}).times == 100


def test_a_sphere_that_was_not_measured_is_not_drawn() -> None:
    assert len(of_places(PATHS).frames[1]["rings"]) == 2


def test_over_a_film_the_gap_has_the_scale_of_its_ring() -> None:
    ring = {"sphere": "a", "view": "front", "row": 50.0, "column": 60.0, "radius": 25.4}
    frames = [{"outlines": [ring]} for _ in range(3)] + [{"outlines": []}]
    film = Film((160, 120), (-0.01, -0.009, -0.008, -0.007), 0, False, Overlays(frames, 2, None))
    scene = of_film(PATHS, "20261123-0007", film)
    assert [frame["time"] for frame in scene.frames] == [-1.5, -0.5, 0.5]
    assert scene.frames[2]["rings"] == [[60.5, 50.5, 25.4, "a", -0.8, 0.6]]
    assert scene.frames[2]["picture"] == "/film/20261123-0007/2.png"


def test_a_picture_without_a_pose_has_no_gap() -> None:
    ring = {"sphere": "a", "view": "top", "row": 50.0, "column": 60.0, "radius": 25.4}
    film = Film((160, 120), (0.0, 0.0004), 0, False, Overlays([{"outlines": [ring]}] * 2, 2, None))
    assert of_film(PATHS, "x", film).frames[1]["gap"] is None
