"""`rigctl analyse` of films of a ball that turns and does not fly: said, with its places."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.unit.cli import odd_films
from tests.unit.cli.falling_ball import (
    RADIUS,
    SIZE,
    answer,
    save,
)

Capsys = pytest.CaptureFixture[str]


def turned(
    folder: Path, capsys: Capsys, sway: tuple[float, float], *, held: bool = False
) -> tuple[Any, Any]:
    """Return what is said of a drawn ball that turns, and its places, shape (frames, 2)."""
    shown = odd_films.turning(sway)
    film = save(folder / "film", odd_films.in_a_holder(shown) if held else shown)
    shot = answer(capsys, str(film), *SIZE, "--fps", "200")
    assert shot["status"] == "refused", shot
    return shot, np.array([shot["positions"][key] for key in ("row_px", "column_px")]).T


def test_a_ball_that_only_turns_is_said_and_its_places_stay_whatever_its_blotches_do(
    tmp_path: Path, capsys: Capsys
) -> None:
    shot, places = turned(tmp_path, capsys, (0.0, 0.0))
    assert "turns on its place" in shot["reason"]
    assert places.shape == (60, 2)
    assert np.all(places.std(axis=0) < 0.04)
    assert places.mean(axis=0) == pytest.approx([100.0, 60.0], abs=0.1)


def test_a_ball_that_turns_in_a_holder_beside_edges_that_flicker_is_said_to(
    tmp_path: Path, capsys: Capsys
) -> None:
    shot, places = turned(tmp_path, capsys, (0.0, 0.0), held=True)
    assert "turns on its place" in shot["reason"]
    assert places.shape == (60, 2)
    assert places.mean(axis=0) == pytest.approx([100.0, 60.0], abs=0.5)


def test_a_ball_whose_one_spot_draws_less_than_its_outline_is_as_large_as_its_rim(
    tmp_path: Path, capsys: Capsys
) -> None:
    film = save(tmp_path / "film", odd_films.turning_in_the_picture())
    shot = answer(capsys, str(film), *SIZE, "--fps", "200")
    assert "turns on its place" in shot["reason"]
    across = float(shot["reason"].split(" px across")[0].split()[-1])
    assert across == pytest.approx(2 * RADIUS, abs=0.5)


@pytest.mark.long
def test_a_ball_that_turns_and_sways_is_seen_to_sway(tmp_path: Path, capsys: Capsys) -> None:
    _, places = turned(tmp_path, capsys, (0.6, -0.5))
    moved = places[30:].mean(axis=0) - places[:30].mean(axis=0)
    assert moved == pytest.approx([0.6, -0.5], abs=0.15)
