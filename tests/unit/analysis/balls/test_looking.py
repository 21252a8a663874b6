"""A film is looked through once, however often its flights are sought at other times."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.balls.films.film import HeldFilm, Picture
from analysis.balls.films.part import Cut, PartOfFilm
from analysis.balls.flight.known import Ball
from analysis.balls.looking import Looked, Sighted, TurnedLook
from analysis.balls.searching import search
from analysis.balls.seen.surroundings import Surroundings
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


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_what_is_seen_of_a_turned_film_is_what_a_look_at_its_turned_pictures_shows(
    turns: int,
) -> None:
    film = counted()
    upright = Looked(film)
    (first, *_), *_ = list(upright.balls())
    looks = film.looks
    (known, *_), *_ = list(TurnedLook(upright, turns).balls())
    assert film.looks == looks
    (anew, *_), *_ = list(Looked(PartOfFilm(film, Cut(), turns)).balls())
    assert known.looks.radius_px == pytest.approx(anew.looks.radius_px, abs=0.02)
    assert known.looks.shading == pytest.approx(anew.looks.shading, abs=0.5)
    assert strongest(known) == pytest.approx(strongest(anew), abs=0.01)
    assert strongest(known) != pytest.approx(strongest(first), abs=1.0)


def strongest(sighted: Sighted) -> Floats:
    return np.array([each[each[:, 2].argmax(), :2] for each in sighted.places if len(each)])


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_what_is_kept_about_a_ball_is_cut_as_from_turned_pictures(turns: int) -> None:
    shown = np.arange(24 * 16, dtype=np.uint16).reshape(24, 16, 1)
    kept = Surroundings({}, 4, {}, 1e6)
    kept.keep(7, shown, np.array([[9.0, 6.0, 1.0]]))
    about = kept.turned({}, (24, 16), turns)
    whole = np.rot90(shown, turns)
    (top, left) = np.argwhere(whole[..., 0] == shown[7, 5, 0])[0]
    box = (top - 1, left - 1, top + 3, left + 2)
    cut = about.cut(7, box)
    assert cut is not None
    assert cut.tolist() == whole[box[0] : box[2], box[1] : box[3]].tolist()
    assert about.cut(8, box) is None
    assert about.cut(7, (0, 0, 3, 3)) is None
