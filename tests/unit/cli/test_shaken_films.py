"""`rigctl analyse` of films that a shaking hand takes: pictures are brought back first."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from scipy import ndimage

from analysis.arrays import Floats
from analysis.balls.films.film import HeldFilm
from analysis.balls.films.steady import ShakenError, SteadyFilm, refuse_shaken
from tests.unit.cli.falling_ball import (
    BALL,
    GROUND,
    RATE,
    SHAPE,
    SIZE,
    Drawn,
    answer,
    bouncing,
    picture,
    save,
)
from tests.unit.cli.odd_films import hand_over, turning


def shifts(count: int) -> Floats:
    """Return how a hand moves the picture down and to the right, px, shape (count, 2)."""
    times = np.arange(count) / RATE
    slow = np.stack([np.sin(8.0 * times), np.cos(11.0 * times)], axis=1)
    fast = np.stack([np.sin(55.0 * times), np.sin(48.0 * times + 1.0)], axis=1)
    return np.asarray(2.0 * slow + 0.3 * fast)


def before_a_wall(drawn: Drawn) -> Drawn:
    """Draw what is behind the ball: a wall of blurred spots."""
    spots = cv2.GaussianBlur(np.random.default_rng(6).normal(0.0, 110.0, SHAPE), (0, 0), 3.0)
    behind = 1.0 - np.clip((drawn - GROUND) / (BALL - GROUND), 0.0, 1.0)
    return np.asarray(np.clip(np.rint(drawn + spots * behind), 0, 255), np.uint8)


def shaken(still: list[Drawn]) -> list[Drawn]:
    moves = zip(still, shifts(len(still)), strict=True)
    moved = [ndimage.shift(each.astype(float), move, mode="nearest") for each, move in moves]
    return [np.asarray(np.clip(np.rint(each), 0, 255), np.uint8) for each in moved]


def test_a_film_of_a_hand_that_shakes_is_measured_as_if_the_camera_stood(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = bouncing()
    film = save(tmp_path / "film", shaken([before_a_wall(picture(row)) for row in rows]))
    shot: Any = answer(capsys, str(film), *SIZE, "--fps", "200")
    (note,) = [note for note in shot["notes"] if "the camera moves" in note]
    assert "furthest frame" in note
    e = shot["impacts"][0]["e"]
    assert e["value"] == pytest.approx(0.8, abs=4 * e["sigma"])
    assert e["sigma"] < 0.01
    seen = shot["positions"]
    still = np.array(rows)[seen["frame"]]
    # Where the camera was in the picture that the others are brought back to.
    off = np.array(seen["row_px"]) - still
    assert np.abs(off - np.median(off)).max() < 0.3


def test_pictures_of_a_camera_that_shakes_are_brought_back_to_one_another() -> None:
    alone = before_a_wall(picture(-100.0))
    moved = np.array(shaken([alone] * 40))
    steady = np.array(list(SteadyFilm(HeldFilm(Path("film"), moved)).pictures()))[..., 0]
    inside = (slice(None), slice(6, -6), slice(6, -6))
    spread = [each[inside].astype(float).std(axis=0).mean() for each in (moved, steady)]
    assert spread[0] > 2.5
    assert spread[1] < 0.7


@pytest.mark.parametrize("plain", [False, True])
def test_a_hand_that_waves_before_a_wall_is_no_camera_that_moves(*, plain: bool) -> None:
    wall = picture(-100.0) if plain else before_a_wall(picture(-100.0))
    waved = [hand_over(wall, 120.0 + 25.0 * np.sin(k / 3.0), 40.0 + 2 * k) for k in range(20)]
    refuse_shaken({k: each[..., None] for k, each in enumerate(waved)})


def test_a_ball_that_sways_before_stripes_is_no_camera_that_moves() -> None:
    refuse_shaken({k: each[..., None] for k, each in enumerate(turning((0.6, -0.5)))})


def test_noise_that_a_codec_carries_from_picture_to_picture_is_no_camera_that_moves() -> None:
    rng, kept, pictures = np.random.default_rng(1), np.zeros((240, 320)), {}
    for frame in range(40):
        if frame % 8 == 0:
            # Half of what was there stays, and the rest is the noise of a new whole picture.
            fresh = cv2.GaussianBlur(rng.normal(0.0, 1.0, kept.shape), (0, 0), 2.0)
            kept = (0.5 * kept if frame else 0.0) + fresh * (2.6 if frame else 3.0) / fresh.std()
        noisy = 24.0 + kept + rng.normal(0.0, 0.3, kept.shape)
        pictures[frame] = np.asarray(np.clip(np.rint(noisy), 0, 255), np.uint8)[..., None]
    assert not refuse_shaken(pictures)


@pytest.mark.parametrize("plain", [False, True])
def test_it_is_said_whether_a_shake_would_be_seen(*, plain: bool) -> None:
    wall = picture(-100.0) if plain else before_a_wall(picture(-100.0))
    assert refuse_shaken(dict.fromkeys(range(20), wall[..., None])) is not plain


def test_a_wall_that_moves_in_the_picture_is_said_to_with_frame_and_distance() -> None:
    moved = shaken([before_a_wall(picture(-100.0))] * 40)
    with pytest.raises(ShakenError, match=r"lies \d\.\d px elsewhere in frame \d+"):
        refuse_shaken({k: each[..., None] for k, each in enumerate(moved)})
