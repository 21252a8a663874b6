"""`rigctl analyse` of balls that are thrown at a wall, and of what turns as if at one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.balls import settling
from tests.unit.cli.falling_ball import RATE, Capsys, Drawn, analysed, picture, said


def at_a_wall(side: int, e: float, speed: float, fall: float, met: float) -> list[Drawn]:
    times = np.arange(66) / RATE
    rows = 110.0 - 220.0 * times + 0.5 * fall * times**2
    across = np.where(times < met, speed * (times - met), -e * speed * (times - met))
    columns = 60.0 + side * (45.0 + across)
    return [picture(row, column) for row, column in zip(rows, columns, strict=True)]


@pytest.mark.parametrize("side", [1, -1])
def test_a_ball_that_is_thrown_at_a_wall_has_e_of_the_wall(
    side: int, tmp_path: Path, capsys: Capsys
) -> None:
    e, speed, fall, met = 0.7, 480.0, 2800.0, 0.17
    shot = analysed(at_a_wall(side, e, speed, fall, met), tmp_path, capsys)
    (impact,) = shot["impacts"]
    assert impact["e"]["value"] == pytest.approx(e, abs=4 * impact["e"]["sigma"])
    assert impact["e"]["sigma"] < 0.03
    assert impact["contact_time_s"] == pytest.approx(met, abs=0.002)
    assert impact["normal"] == pytest.approx([0.0, side, 0.0], abs=0.03)
    assert impact["v_n"]["value"] == pytest.approx(-speed / fall * 9.80665, rel=0.03)
    assert "bounce 1 of 1: off a wall" in said(shot, "off a wall")


@pytest.mark.parametrize(("unsure", "bounces"), [(0.28, 0), (0.02, 1)])
def test_what_turns_as_at_a_wall_and_hardly_falls_as_stated_has_no_bounce(
    unsure: float,
    bounces: int,
    tmp_path: Path,
    capsys: Capsys,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A hand turns a ball so. One whose fall is surely another one has another diameter."""
    fit = settling.fit_flights

    def falls_otherwise(*asked: Any) -> Any:
        found = fit(*asked)
        third = (found.scale_of_diameter[0] / 3.0, unsure)
        return replace(found, contradiction=True, scale_of_fall=third)

    monkeypatch.setattr(settling, "fit_flights", falls_otherwise)
    shot = analysed(at_a_wall(1, 0.7, 480.0, 2800.0, 0.17), tmp_path, capsys)
    assert len(shot["impacts"]) == bounces
