"""`rigctl precompile` runs what first films and accuracy runs need."""

from __future__ import annotations

from pathlib import Path

import pytest

from analysis.balls.document import ball_document
from rigctl.cli.frames.precompile import DISC_PX, REBOUND, locate_drawn_disc, measure_drawn_ball


def test_the_drawn_film_is_measured_through_its_bounce(tmp_path: Path) -> None:
    document = ball_document(measure_drawn_ball(tmp_path / "ball").measured, ())
    (impact,) = document["impacts"]
    assert impact["e"]["value"] == pytest.approx(REBOUND, abs=0.02)


def test_the_drawn_disc_is_found_where_it_was_drawn() -> None:
    row, column, _ = locate_drawn_disc()
    assert (row, column) == pytest.approx((DISC_PX / 2, DISC_PX / 2), abs=0.05)
