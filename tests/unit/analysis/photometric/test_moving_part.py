"""Large pictures, most of which never show a sphere: the rendered film in the midst of noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.errors import ShotRefusedError
from analysis.imaging.views import View
from analysis.photometric.follow.votes import moving_part
from analysis.photometric.method import followed_pair, measure_poses
from analysis.photometric.teaching import teach
from simulators.world import Launch, WorldDescription, render_shot
from tests.unit.analysis.rendered import setup_of

SEED, CORNER = 12, (200, 300)
ROWS, COLUMNS = 600, 900
WORLD = WorldDescription()
SETUP = setup_of(WORLD)


def rendered(shot, seed=SEED):
    return render_shot(WORLD, Launch(40.0, 40.0, 7e-3), seed, shot=shot)


def widened(frames):
    """The film in the midst of a picture of one grey level, with the noise of its pixels."""
    rng, still = np.random.default_rng(1), frames[0, :8, :8]
    wide = rng.normal(still.mean(), max(still.std(), 1.0), (len(frames), ROWS, COLUMNS))
    (top, left), (height, width) = CORNER, frames.shape[1:]
    wide[:, top : top + height, left : left + width] = frames
    return np.clip(np.rint(wide), 0, 255).astype(np.uint8)


def seen_wide(known):
    """The pair before the wide picture: all of the film's pixels lie at the corner and on."""
    optics = known.camera.optics
    optics = optics._replace(
        origins=optics.origins + np.array(CORNER, dtype=float),
        rows=optics.rows + CORNER[0],
        middle=(optics.middle[0] + CORNER[0], optics.middle[1] + CORNER[1]),
    )
    return replace(known, camera=replace(known.camera, optics=optics))


@pytest.fixture(scope="module")
def known():
    first = rendered(1)
    return teach([(first.frames, first.times_s, SETUP)])


def test_a_pair_is_where_it_is_however_large_the_picture(known):
    shot = rendered(2)
    plain, _ = measure_poses(shot.frames, shot.times_s, SETUP, known)
    wide, same = measure_poses(widened(shot.frames), shot.times_s, SETUP, seen_wide(known))
    assert np.array_equal(same.camera.optics.rows, seen_wide(known).camera.optics.rows)
    for small, large in zip(plain.centres, wide.centres, strict=True):
        assert np.array_equal(small.frames, large.frames)
        off = (large.position - small.position) * WORLD.optics.scale_px_per_m
        assert np.nanmax(np.abs(off)) < 0.02
    k = int(plain.centres[0].frames[3])
    here, there = (each.spheres[0][View.FRONT].outlines[k].circle for each in (plain, wide))
    assert there.row - here.row == pytest.approx(CORNER[0], abs=0.02)
    assert there.column - here.column == pytest.approx(CORNER[1], abs=0.02)


def test_the_part_holds_all_discs_and_little_else(known):
    shot = rendered(2)
    part = moving_part(widened(shot.frames), seen_wide(known))
    assert part is not None
    radius = WORLD.sphere_a.radius_m * WORLD.optics.scale_px_per_m
    for front in shot.truth["centres_front_px"]:
        for row, column in (place for place in front if place is not None):
            last = shot.frames.shape[1] - 1 + CORNER[0], shot.frames.shape[2] - 1 + CORNER[1]
            low, high = row + CORNER[0] - radius, row + CORNER[0] + radius
            assert part.rows[0] <= low or low < CORNER[0]
            assert part.rows[1] > min(high, last[0])
            assert part.columns[0] <= column + CORNER[1] - radius or column < radius
            assert part.columns[1] > min(column + CORNER[1] + radius, last[1])
    height, width = (end - begin for begin, end in (part.rows, part.columns))
    assert height * width < 0.4 * ROWS * COLUMNS


def test_a_small_picture_and_a_still_one_are_looked_at_whole(known):
    shot = rendered(2)
    assert moving_part(shot.frames, known) is None
    assert moving_part(widened(shot.frames[:1].repeat(6, axis=0)), seen_wide(known)) is None


def test_other_spheres_in_a_large_picture_are_not_taken_for_the_pair(known):
    strangers = rendered(1, SEED + 1)
    frames = widened(strangers.frames)
    with pytest.raises(ShotRefusedError, match="learned"):
        followed_pair(frames, strangers.times_s, SETUP, seen_wide(known), extend=True)
