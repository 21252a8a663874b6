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
    looks = Looks(RADIUS, 0.1, np.ones(1), np.ones(1), ())
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
