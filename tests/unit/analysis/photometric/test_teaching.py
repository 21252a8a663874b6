"""A shot that is followed in a wrong turn does not teach where its markers lie."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.motion.rotation import rotation_matrix
from analysis.photometric.follow.film import Film
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.method import learned_film
from analysis.photometric.teaching import turns_freely
from simulators.world import Launch, WorldDescription, render_shot
from tests.unit.analysis.rendered import setup_of

WORLD = WorldDescription()


@pytest.fixture(scope="module")
def learned() -> tuple[Film, Appearance]:
    shot = render_shot(WORLD, Launch(60.0, 60.0, 5e-3), 11, shot=1)
    return learned_film(shot.frames, shot.times_s, setup_of(WORLD))


def test_true_turns_hold_one_rate_on_either_side(learned: tuple[Film, Appearance]) -> None:
    assert turns_freely(*learned)


@pytest.mark.parametrize("sphere", [0, 1])
def test_turns_that_speed_up_in_flight_are_none_of_a_free_sphere(
    learned: tuple[Film, Appearance], sphere: int
) -> None:
    """By 20 rad/s in a flight of ten frames, without any jump."""
    film, known = learned
    rotation = film.rotation.copy()
    more = 0.5 * 2e3 * (film.times_s - film.times_s[4]) ** 2
    rotation[sphere] = rotation_matrix(np.outer(more, [0.0, 0.0, 1.0])) @ rotation[sphere]
    assert not turns_freely(replace(film, rotation=rotation), known)
