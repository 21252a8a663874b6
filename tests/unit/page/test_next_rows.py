"""Which measurements a table's owner is asked for next."""

from __future__ import annotations

import json
import math
from typing import Any

from analysis.model.verdict.standing import Standing, Word
from rigctl.page.model.next import is_table, next_measurements

UNEXPLAINED = Standing(Word.UNEXPLAINED)


def found(*speeds: float) -> dict[str, Any]:
    """Return what a fit says of a table of impacts at these approach speeds, m/s."""
    points = json.dumps({"x": [math.log(v) for v in speeds]})
    return {"paths": [], "findings": [{"covariate": "ln v_n", "points": points}]}


def test_the_ends_of_the_speeds_and_the_widest_gap_are_asked_for() -> None:
    said = next_measurements(found(4.0, 1.5, 1.6, 3.9), UNEXPLAINED)
    assert "below 1 m/s and above 6 m/s" in said
    assert "between 1.6 and 3.9 m/s" in said


def test_speeds_without_a_gap_ask_for_none_to_be_filled() -> None:
    assert "gap" not in next_measurements(found(2.0, 2.2, 2.4), UNEXPLAINED)


def test_two_effects_that_agree_are_named_by_their_titles() -> None:
    standing = Standing(Word.ALIKE, tell=("drag", "wind"))
    said = next_measurements(found(1.0, 3.0), standing)
    assert "Air drag" in said
    assert "part there" in said


def test_a_table_at_its_floor_asks_for_none() -> None:
    assert "None are needed" in next_measurements(found(1.0, 3.0), Standing(Word.FLOOR))


def test_impacts_at_one_speed_ask_for_several() -> None:
    assert "several approach speeds" in next_measurements(found(2.0, 2.0), UNEXPLAINED)


def test_a_campaign_with_paths_is_no_table() -> None:
    assert is_table(found(1.0))
    assert not is_table({"paths": [{"shot": 1}]})
