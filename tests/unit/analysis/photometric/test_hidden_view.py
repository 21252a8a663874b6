"""A sphere that another one hides in the mirror, in the light of a lamp that casts shadows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.photometric.method import followed_film
from analysis.photometric.render.camera import disc_of
from analysis.photometric.teaching import teach
from simulators.world import Launch, RenderedShot, WorldDescription, render_shot
from simulators.world.lamp import Lamp
from simulators.world.optics import Optics
from tests.unit.analysis.rendered import setup_of

pytestmark = pytest.mark.long

WORLD = WorldDescription(optics=replace(Optics(), lamp=Lamp(strength=110.0, room=50.0)))
SETUP = setup_of(WORLD)
SEED, SIGMAS, SHIFT_PX = 5, 6.0, 0.3
HIDDEN = 0.35


def shot(number: int, offset_m: float) -> RenderedShot:
    return render_shot(WORLD, Launch(60.0, 60.0, offset_m), SEED, shot=number)


def overlap(shot: RenderedShot, frame: int) -> float:
    """Return the share of the mirror's disc of sphere b that lies behind that of sphere a."""
    first, second = (np.array(place) for place in shot.truth["centres_top_px"][frame])
    apart = min(float(np.hypot(*(first - second))) / 40.0, 1.0)
    return float(2.0 * (np.arccos(apart) - apart * np.sqrt(1.0 - apart**2)) / np.pi)


@pytest.fixture(scope="module")
def upright() -> RenderedShot:
    """The line of centres is steep: after the contact b flies below a."""
    return shot(2, 0.021)


def test_the_height_of_a_hidden_sphere_is_not_stated_better_than_it_is_known(
    upright: RenderedShot,
) -> None:
    lesson = shot(1, 0.008)
    known = teach([(lesson.frames, lesson.times_s, SETUP)])
    assert known is not None
    film = followed_film(upright.frames, upright.times_s, known)
    optics, radius_m = known.camera.optics, known.spheres[1].radius_m
    hidden = [k for k in range(24) if film.placed[1, k] and overlap(upright, k) > 1.0 - HIDDEN]
    assert hidden
    for k in hidden:
        centre: NDArray[np.float64] = film.centre[1, k]
        row = disc_of(optics, 1, centre, radius_m)[0]
        off = abs(float(row) - float(np.array(upright.truth["centres_top_px"][k][1])[0]))
        sigma_px = optics.scales[1] * np.sqrt(film.covariance[1, k, 2, 2])
        assert off < SHIFT_PX + SIGMAS * sigma_px
