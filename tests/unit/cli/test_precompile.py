"""`rigctl precompile` runs what first films and accuracy runs need."""

from __future__ import annotations

from pathlib import Path

import pytest

from analysis.balls.document import ball_document
from rigctl.cli.frames.precompile import (
    DISC_PX,
    HALF_AXES,
    REBOUND,
    RESTS_PX,
    SHAPE,
    SMEARED_SHAPE,
    find_smeared_disc,
    locate_drawn_disc,
    look_for_resting_ball,
    measure_drawn_ball,
    place_ball_with_patches,
)


def test_the_drawn_film_is_measured_through_its_bounce(tmp_path: Path) -> None:
    document = ball_document(measure_drawn_ball(tmp_path / "ball").measured, ())
    (impact,) = document["impacts"]
    assert impact["e"]["value"] == pytest.approx(REBOUND, abs=0.02)


def test_the_drawn_disc_is_found_where_it_was_drawn() -> None:
    row, column, _ = locate_drawn_disc()
    assert (row, column) == pytest.approx((DISC_PX / 2, DISC_PX / 2), abs=0.05)


def test_the_drawn_ball_that_rests_is_found_on_its_place(tmp_path: Path) -> None:
    said = look_for_resting_ball(tmp_path / "rests")
    assert f"rests or turns on its place: at ({RESTS_PX}, {SHAPE[1] / 2})" in said


def test_the_smeared_disc_is_one_and_lies_in_its_oval() -> None:
    (found,) = find_smeared_disc()
    (row, column), (across, down) = (n / 2 for n in SMEARED_SHAPE), HALF_AXES
    assert abs(found.row - row) < down / 2
    assert abs(found.column - column) < across / 2


def test_the_ball_with_patches_is_placed_where_it_was_drawn() -> None:
    assert place_ball_with_patches() == pytest.approx((DISC_PX / 2, DISC_PX / 2), abs=0.1)
