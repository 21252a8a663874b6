"""Films are read once for all who look, and without their large parts where these are not shown."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rigctl.errors import NotFoundError
from rigctl.page.shots.films import Films

TIMES = [0.0, 0.001, 0.002]
RESULT = {
    "status": "measured",
    "poses": [1, 2, 3],
    "overlay": [{"outlines": [], "markers": []}],
    "contact_time_s": 0.0015,
    "frame_rate_hz": 1000.0,
}


class Folders:
    """A store with one film of three frames, the second the brightest."""

    def __init__(self) -> None:
        self.reads = 0
        self.folders = self

    def result(self, shot: str, number: int) -> dict[str, Any]:
        self.reads += 1
        if number > 2:
            raise NotFoundError("has no such result", part=shot)
        return RESULT

    def manifest(self, shot: str) -> dict[str, Any]:
        self.reads += 1
        return {"frames": {"shape": [3, 4, 5], "times_s": TIMES}}

    def frames(self, shot: str) -> Any:
        pixels = np.zeros((3, 4, 5), np.uint8)
        pixels[1] = 200
        return SimpleNamespace(pixels=pixels)


def shot(results: int) -> Any:
    return SimpleNamespace(id="shot-1", results=results)


@pytest.fixture
def store() -> Folders:
    return Folders()


def test_a_film_says_its_size_its_times_and_where_most_is_seen(store: Folders) -> None:
    film = Films(store).film(shot(0))
    assert (film.size, film.times_s, film.brightest) == ((5, 4), tuple(TIMES), 1)
    assert film.overlays.contact_frame is None


def test_the_contact_is_that_of_the_result(store: Folders) -> None:
    assert Films(store).film(shot(1)).overlays.contact_frame == 2


def test_however_many_look_each_file_is_read_once(store: Folders) -> None:
    films = Films(store)
    for _ in range(5):
        films.film(shot(1))
        films.result(shot(1))
    assert store.reads == 2


def test_a_further_result_is_read_anew(store: Folders) -> None:
    films = Films(store)
    films.result(shot(1))
    films.result(shot(2))
    assert store.reads == 2


def test_poses_and_drawings_are_no_part_of_what_tables_show(store: Folders) -> None:
    assert set(Films(store).result(shot(1))) == {"status", "contact_time_s", "frame_rate_hz"}


def test_a_shot_without_a_result_has_an_empty_one(store: Folders) -> None:
    films = Films(store)
    assert films.result(shot(0)) == {}
    assert films.result(shot(3)) == {}


def test_a_film_in_which_nothing_stands_out_of_the_noise_is_blank(store: Folders) -> None:
    noise = np.random.default_rng(1).normal(4.0, 1.5, (3, 192, 240)).clip(0, 255)
    covered = noise.astype(np.uint8)
    seen = covered.copy()
    seen[1, 50:90, 50:90] = 120
    for pixels, blank in ((covered, True), (np.zeros_like(covered), True), (seen, False)):
        store.frames = lambda shot, pixels=pixels: SimpleNamespace(pixels=pixels)
        assert Films(store).film(shot(0)).blank is blank
