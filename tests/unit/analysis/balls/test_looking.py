"""A film is looked through once, however often its flights are sought at other times."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from analysis.balls.films.film import HeldFilm, Picture
from analysis.balls.flight.known import Ball
from analysis.balls.looking import Looked
from analysis.balls.searching import search
from tests.unit.cli.falling_ball import DIAMETER_MM, RATE, SHAPE, bouncing, picture

FRAMES = 120


class Counted(HeldFilm):
    looks = 0

    def pictures(self) -> Iterator[Picture]:
        self.looks += 1
        yield from super().pictures()


def counted(scale: int = 1) -> Counted:
    rows = np.array(bouncing(FRAMES))
    drawn = np.array([np.kron(picture(row), np.ones((scale, scale), np.uint8)) for row in rows])
    return Counted(Path("drawn"), drawn)


def test_other_times_of_the_same_film_need_no_look_at_its_pictures() -> None:
    film, ball = counted(), Ball(1e-3 * DIAMETER_MM)
    looked = Looked(film)
    times = np.arange(FRAMES) / RATE
    first = search(looked, times, ball)
    looks = film.looks
    again = search(looked, times, ball)
    assert film.looks == looks
    assert again.chain.times_s.tolist() == first.chain.times_s.tolist()
    # At half of the rate a ball four times as large falls so.
    slower = search(looked, 2.0 * times, Ball(4e-3 * DIAMETER_MM))
    assert film.looks == looks
    assert np.allclose(slower.chain.times_s, 2.0 * first.chain.times_s, atol=2.0 / RATE)


def test_a_ball_of_a_large_picture_is_looked_for_once_where_smaller_ones_are_sought_too() -> None:
    large = 4
    looked = Looked(counted(large))
    seen = [one.looks for some in looked.balls() for one in some]
    assert np.prod(looked.ground.shape[:2]) == large**2 * np.prod(SHAPE)
    assert len({one.seen for one in seen}) == len(seen)
    assert sum(abs(one.radius_px - 14.0 * large) < large for one in seen) == 1
