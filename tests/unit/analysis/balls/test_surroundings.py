"""What a search keeps of a large film is what the film shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from analysis.balls.films.film import HeldFilm
from analysis.balls.seen.looks import Looks
from analysis.balls.seen.surroundings import Surroundings
from analysis.balls.seen.windows import Motion, Seen, cut_windows

RADIUS = 8.0


def a_film() -> tuple[HeldFilm, Motion]:
    rng = np.random.default_rng(1)
    still = rng.integers(40, 60, (120, 90), dtype=np.uint8)
    frames = np.repeat(still[None], 12, axis=0)
    rows, columns = np.mgrid[:120, :90]
    places = np.stack([20.0 + 7.0 * np.arange(12), np.full(12, 45.0)], axis=1)
    for frame, (row, column) in zip(frames, places, strict=True):
        frame[np.hypot(rows - row, columns - column) < RADIUS] = 200
    speeds = np.tile([700.0, 0.0], (12, 1))
    return HeldFilm(Path("film"), frames), Motion(np.arange(12), places, speeds)


def test_windows_are_the_same_whether_a_film_is_read_again_or_was_kept() -> None:
    film, motion = a_film()
    looks = Looks(RADIUS, 0.1, np.ones((6, 1)), np.ones((1, 1)), np.ones(1), ())
    pictures = dict(enumerate(film.pictures()))
    about = Surroundings.new(RADIUS, pictures)
    for frame, picture in pictures.items():
        about.keep(frame, picture, motion.places[frame : frame + 1] + 0.4)
    again = cut_windows(film, looks, motion, 0.01)
    kept = cut_windows(film, looks, motion, 0.01, Seen(None, about))
    assert len(again) == len(kept) == 12
    for a, b in zip(again, kept, strict=True):
        assert (a.frame, a.top, a.left) == (b.frame, b.top, b.left)
        np.testing.assert_array_equal(a.pixels, b.pixels)


def test_a_box_that_reaches_beyond_what_was_kept_is_not_given() -> None:
    film, _ = a_film()
    about = Surroundings.new(RADIUS, {})
    (picture, *_) = film.pictures()
    about.keep(0, picture, np.array([[60.0, 45.0, 1.0]]))
    reach = about.reach_px
    inside = about.cut(0, (60 - reach, 40, 70, 50))
    assert inside is not None
    np.testing.assert_array_equal(inside, picture[60 - reach : 70, 40:50])
    assert about.cut(0, (59 - reach, 40, 70, 50)) is None
    assert about.cut(1, (50, 40, 70, 50)) is None


def test_a_ball_that_rests_outside_its_flights_is_no_part_of_what_stands_still() -> None:
    film, motion = a_film()
    pictures = [picture.copy() for picture in film.pictures()]
    rows, columns = np.mgrid[:120, :90]
    resting = np.hypot(rows - 100.0, columns - 45.0) < RADIUS
    # The ball rests for twice as long as it flies, where it flew past before.
    still = pictures[0][resting].copy()
    for _ in range(24):
        pictures.append(pictures[0].copy())
        pictures[-1][resting] = 200
    whole = HeldFilm(Path("film"), np.stack([picture[..., 0] for picture in pictures]))
    looks = Looks(RADIUS, 0.1, np.ones((6, 1)), np.ones((1, 1)), np.ones(1), ())
    beside = np.column_stack([np.arange(12, 36), np.tile([[100.0, 45.0]], (24, 1))])
    last = cut_windows(whole, looks, motion, 0.0, Seen(beside=beside))[-1]
    ground = last.pixels[1]
    inside = resting[last.top : last.top + len(ground), last.left : last.left + ground.shape[1]]
    assert np.median(ground[inside]) == np.median(still)


def test_a_ball_that_rests_beside_what_is_looked_at_hides_nothing_there() -> None:
    film, motion = a_film()
    looks = Looks(RADIUS, 0.1, np.ones((6, 1)), np.ones((1, 1)), np.ones(1), ())
    # No box of the flight reaches the picture's first rows and columns.
    beside = np.array([[k, -60.0, -60.0] for k in range(12)])
    bare = cut_windows(film, looks, motion, 0.0)
    for one, other in zip(
        bare, cut_windows(film, looks, motion, 0.0, Seen(beside=beside)), strict=True
    ):
        np.testing.assert_array_equal(one.pixels, other.pixels)
