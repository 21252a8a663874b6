"""Why no contact is seen, held against the world that the films show."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.setup import Setup
from analysis.shot import RefusedShot, analyse_shot
from simulators.world import Launch, RenderedShot, WorldDescription, render_shot
from simulators.world.description import Sphere
from tests.unit.analysis.rendered import setup_of

PLAIN = Sphere(markers=0)
WORLD = WorldDescription(sphere_a=PLAIN, sphere_b=PLAIN)
TOUCH_MM = 25.4
PX_PER_MM = WORLD.optics.scale_px_per_m / 1e3


def reason(frames: NDArray[np.uint8], setup: Setup | None = None) -> str:
    times_s = np.arange(len(frames)) / 1000.0
    shot = analyse_shot(frames, times_s, setup or setup_of(WORLD))
    assert isinstance(shot, RefusedShot), shot
    return shot.reason


def apart_mm(film: RenderedShot) -> NDArray[np.float64]:
    """Return how far the spheres' true centres are apart in each frame that shows both."""
    front, top = (
        np.array([[at or (np.nan, np.nan) for at in pair] for pair in film.truth[view]])
        for view in ("centres_front_px", "centres_top_px")
    )
    across, depth = front[:, 1] - front[:, 0], top[:, 1, 0] - top[:, 0, 0]
    return np.asarray(np.hypot(np.hypot(across[:, 0], across[:, 1]), depth) / PX_PER_MM)


@pytest.mark.parametrize("frames", [24, 60])
def test_spheres_that_miss_each_other_pass_with_so_many_millimetres_between_them(
    frames: int,
) -> None:
    film = render_shot(WORLD, Launch(55.0, 55.0, 0.030), 11, frames=frames)
    found = re.search(r"with (.+) mm between them, nearest in frame (\d+) ", reason(film.frames))
    assert found is not None
    true = apart_mm(film)
    assert float(found[1]) == pytest.approx(np.nanmin(true) - TOUCH_MM, abs=0.05)
    assert abs(int(found[2]) - int(np.nanargmin(true))) <= 1


def test_a_film_that_ends_before_the_contact_lacks_so_many_milliseconds() -> None:
    film = render_shot(WORLD, Launch(55.0, 55.0, 0.008), 11)
    found = re.search(r"would touch (.+) ms after the last frame", reason(film.frames[:10]))
    assert found is not None
    assert float(found[1]) == pytest.approx(1e3 * film.truth["contact_time_s"] - 9.0, abs=0.1)


def test_a_film_that_begins_after_the_contact_shows_spheres_that_part() -> None:
    film = render_shot(WORLD, Launch(55.0, 55.0, 0.008), 11)
    assert "part already in frame 0" in reason(film.frames[14:])


def test_a_sphere_that_leaves_the_view_is_named_with_edge_and_frame() -> None:
    film = render_shot(WORLD, Launch(55.0, 55.0, 0.035), 11, frames=90)
    said = re.findall(
        r"sphere (\w) crosses the (\w+) edge of the front view after frame (\d+)",
        reason(film.frames),
    )
    assert {sphere: edge for sphere, edge, _ in said} == {"a": "right", "b": "lower"}
    radius = 0.5 * TOUCH_MM * PX_PER_MM
    for sphere, edge, last in said:
        row, column = film.truth["centres_front_px"][int(last) + 1]["ab".index(sphere)]
        below, beyond = WORLD.optics.front_rows[1], WORLD.optics.columns
        over = row + radius - below if edge == "lower" else column + radius - beyond
        # Half a step of 3 pixels from frame to frame.
        assert over > -1.5


def test_a_sphere_that_was_not_fired_is_missing_in_each_view() -> None:
    film = render_shot(WORLD, Launch(55.0, 55.0, 0.008, 0.0, 0.5), 11)
    said = reason(film.frames)
    assert "shows 1 of 2 in the front view and 1 of 2 in the top view" in said
    setup = setup_of(WORLD)
    alone = replace(setup, camera=replace(setup.camera, top_view_rows=None))
    assert "shows 1 of 2 in the front view, as discs" in reason(film.frames, alone)


def test_of_spheres_as_dark_as_what_is_behind_them_no_meeting_is_claimed() -> None:
    film = render_shot(WORLD, Launch(55.0, 55.0, 0.008), 11)
    still = np.median(film.frames, axis=0)
    chance = np.random.default_rng(2).integers(0, 5, film.frames.shape, dtype=np.uint8)
    for contrast in (0.0, 0.02):
        faint = np.rint(still + contrast * (film.frames - still)).astype(np.uint8)
        assert not re.search("part already|pass each other|would touch", reason(faint + chance))
    assert "something else than the spheres" in reason(np.rint(still).astype(np.uint8) + chance)
