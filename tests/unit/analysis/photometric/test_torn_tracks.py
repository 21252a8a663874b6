"""Spheres that rise before the mirror: poses are true or they are not there."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.photometric.method import followed_film
from analysis.photometric.teaching import teach
from analysis.shot import AnalysisOptions, MeasuredShot, analyse_shot
from simulators.world import Launch, WorldDescription, render_shot
from simulators.world.optics import Optics
from tests.unit.analysis.rendered import setup_of

WORLD = WorldDescription()
SETUP = setup_of(WORLD)
LAUNCHES = (Launch(60.0, 60.0, 0.004), Launch(45.0, 45.0, 0.009))
STEEP = Launch(61.0, 61.0, 0.018)


@pytest.fixture(scope="module")
def known():
    shots = [
        render_shot(WORLD, launch, 5, shot=number) for number, launch in enumerate(LAUNCHES, 1)
    ]
    return teach([(shot.frames, shot.times_s, SETUP) for shot in shots])


@pytest.fixture(scope="module")
def steep():
    """A film in which one sphere rises through the rows of the mirror's view and out of them."""
    return render_shot(WORLD, STEEP, 5, frames=100, shot=7)


def true_centres(shot, sphere, optics: Optics):
    rows = [own[sphere] for own in shot.truth["centres_front_px"]]
    heights = [own[sphere] for own in shot.truth["centres_top_px"]]
    front = np.array([own or (np.nan, np.nan) for own in rows]) - optics.front_origin_px
    top = optics.top_origin_px[0] - np.array([own[0] if own else np.nan for own in heights])
    return np.column_stack([front, top]) / optics.scale_px_per_m


def test_no_pose_is_given_where_a_direct_image_meets_the_mirrors(known, steep):
    measured = analyse_shot(
        steep.frames, steep.times_s, SETUP, AnalysisOptions(method="photometric"), known
    )
    assert isinstance(measured, MeasuredShot)
    for sphere, own in enumerate(measured.centres):
        off = own.position - true_centres(steep, sphere, WORLD.optics)[own.frames]
        assert np.nanmax(np.abs(off)) < 60e-6
        assert np.nanmax(np.abs(off) / own.sigma) < 12
    rows = 132.0 + 1574.8 * true_centres(steep, 0, WORLD.optics)[:, 0]
    assert np.nanmin(rows) < 40
    assert rows[measured.centres[0].frames].min() > 60
    assert any("meets what the mirror shows" in note for note in measured.notes)


def test_a_sphere_that_the_mirror_still_shows_is_not_taken_for_the_background(known, steep):
    film = followed_film(steep.frames, steep.times_s, known)
    rows, columns = np.indices(film.background.shape)
    optics = WORLD.optics
    scene = optics.background + optics.background_per_row * (rows + 4)
    scene = scene + optics.background_per_column * (columns + 4)
    assert np.abs(film.background - scene).max() < 3.0
