"""Films that are too large for memory are decoded twice where the temporary folder has room."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from analysis.balls.films.film import Film, FilmHead, Picture
from analysis.balls.films.kept import KeptPictures

FRAMES, HEIGHT, WIDTH = 7, 6, 9


class CountedFilm(Film):
    """A film that counts how often its pictures are decoded."""

    def __init__(self, kind: type[np.uint8] | type[np.uint16] = np.uint8) -> None:
        super().__init__(Path("counted"), FilmHead(FRAMES, HEIGHT, WIDTH, 3))
        rng = np.random.default_rng(5)
        most = np.iinfo(kind).max
        self.shown = rng.integers(0, most, (FRAMES, HEIGHT, WIDTH, 3), dtype=kind, endpoint=True)
        self.readings = 0

    def _read(self) -> Iterator[Picture]:
        self.readings += 1
        yield from self.shown


@pytest.fixture(autouse=True)
def no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("analysis.balls.films.film.HELD_BYTES", 100)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_a_large_film_is_decoded_twice_and_its_pictures_stay_as_they_are(
    kind: type[np.uint8] | type[np.uint16],
) -> None:
    film = CountedFilm(kind)
    for _ in range(4):
        assert np.array_equal(np.array(list(film.pictures())), film.shown)
    assert film.readings == 2


def test_a_film_that_is_looked_through_once_needs_no_temporary_file(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def none(_: int) -> KeptPictures:
        raise AssertionError("a temporary file was made")

    monkeypatch.setattr("analysis.balls.films.film.KeptPictures", none)
    film = CountedFilm()
    assert np.array_equal(film.chosen([1, 4])[4], film.shown[4])
    assert np.array_equal(np.array(list(film.pictures())), film.shown)


def test_frames_that_are_chosen_from_a_film_that_was_looked_through_leave_nothing_to_decode() -> (
    None
):
    film = CountedFilm()
    assert np.array_equal(np.array(list(film.pictures())), film.shown)
    assert np.array_equal(film.chosen([1, 4])[4], film.shown[4])
    assert np.array_equal(np.array(list(film.pictures())), film.shown)
    assert film.readings == 2


def test_a_look_that_stops_early_keeps_no_part_of_a_film() -> None:
    film = CountedFilm()
    next(iter(film.pictures()))
    assert np.array_equal(np.array(list(film.pictures())), film.shown)


def test_a_large_film_is_decoded_again_where_the_folder_is_full(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    film = CountedFilm()
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=1000))
    for _ in range(4):
        assert np.array_equal(np.array(list(film.pictures())), film.shown)
    assert film.readings == 4


def test_frames_are_chosen_without_the_rest_of_a_film_where_the_folder_is_full(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    film = CountedFilm()
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=1000))
    shown, read = film.shown, list[int]()

    def reading() -> Iterator[Picture]:
        for number in range(100 * FRAMES):
            read.append(number)
            yield shown[number % FRAMES]

    monkeypatch.setattr(film, "_read", reading)
    assert np.array_equal(film.chosen([1])[1], shown[1])
    # A thread of its own reads a few ahead.
    assert len(read) < 2 * FRAMES
