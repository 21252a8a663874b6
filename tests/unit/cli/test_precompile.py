"""`rigctl precompile` runs what a first film of a ball runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from rigctl.cli.frames.balls import ball_document
from rigctl.cli.frames.precompile import REBOUND, measure_drawn_ball


def test_the_drawn_film_is_measured_through_its_bounce(tmp_path: Path) -> None:
    document = ball_document(measure_drawn_ball(tmp_path / "ball").measured, ())
    (impact,) = document["impacts"]
    assert impact["e"]["value"] == pytest.approx(REBOUND, abs=0.02)
