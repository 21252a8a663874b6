"""Of few shots an alarm has to stand without the two that speak loudest for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.model.data.tables import Data
from analysis.model.structure.alarm import alarms, is_short
from analysis.model.structure.lackoffit import Cell
from analysis.model.verdict.documents import verdict_report
from analysis.model.verdict.selection import explain
from analysis.model.verdict.words import doubts, verdict_sentence
from tests.unit.analysis.model.chosen import EFFECTS
from tests.unit.analysis.model.hard_spheres import Hidden, campaign
from tests.unit.analysis.model.reported import reported

SWAYING_M = 6e-5
"""Of this size two of ten shots alarm with less than 0.85 of it, and no shot is thrown out."""


def cell(*, p: float = 1e-6, carried: float = 0.5, rest: float = 1.0) -> Cell:
    return Cell("spin n", "time", 60.0, 5, p, p, carried, rest)


@pytest.mark.parametrize(
    ("shots", "found", "alarming"),
    [
        (60, cell(carried=0.59), True),
        (60, cell(carried=0.61), False),
        (60, cell(carried=0.61, rest=1e-4), True),
        (13, cell(carried=0.83), True),
        (12, cell(carried=0.5), False),
        (12, cell(carried=0.9, rest=1e-4), True),
        (5, cell(rest=1e-4), True),
        (4, cell(rest=1e-4), False),
        (60, cell(p=0.006, rest=1e-4), False),
    ],
)
def test_an_alarm_is_believed_by_how_many_shots_speak_for_it(
    shots: int, found: Cell, alarming: bool
) -> None:
    assert alarms(found, shots) is alarming


@pytest.mark.parametrize(
    ("shots", "found", "error", "short"),
    [
        (5, cell(), 2.3, True),
        (12, cell(), 1.6, True),
        (5, cell(), 1.4, False),
        (5, cell(p=0.006), 2.3, False),
        (13, cell(), 2.3, False),
        (4, cell(), 2.3, False),
    ],
)
def test_what_leaves_few_shots_far_from_the_floor_is_not_all(
    shots: int, found: Cell, error: float, short: bool
) -> None:
    assert is_short([found], shots, error) is short


def swaying(shots: tuple[int, ...]) -> Data:
    """Return ten shots, in some of which a sphere is seen to sway."""
    data = campaign(10, 91)
    position = data.position.copy()
    for k in shots:
        position[k, :, 0, 0] += SWAYING_M * np.sin(np.arange(position.shape[1]) / 3)
    return replace(data, position=position)


def test_what_sways_in_two_of_ten_shots_is_theirs_and_said_to_be() -> None:
    data = swaying((1, 4))
    found = verdict_report("nylon", data, explain(data, EFFECTS))
    assert not found.unexplained
    assert "two of the 10 shots carry it" in doubts(found)[0]


def test_what_acts_in_all_of_ten_shots_is_unexplained() -> None:
    data = campaign(10, 83, hidden=Hidden(pull=120.0))
    assert explain(data, EFFECTS).verdict == "unexplained"


def test_one_shot_is_told_how_many_more_to_fire() -> None:
    assert verdict_sentence(reported(used=1)) == (
        "nylon: 1 shot is too few to tell what is missing: what stands out may be an error of its "
        "own. Add 4 at least, and better 12, at several speeds and angles: pressures and "
        "offsets, or heights of a fall."
    )


def test_what_two_of_ten_shots_leave_over_is_told_beside_the_verdict() -> None:
    left = {
        **{"channel": "relative position t", "covariate": "time", "chi2": 40.0},
        **{"degrees_of_freedom": 5, "p_value": 1e-7, "p_familywise": 1e-5},
        "of_measurement": False,
    }
    (said,) = doubts(reported(used=10, structure=[left]))
    assert "relative position t against time, but two of the 10 shots carry it" in said


def test_of_one_shot_what_would_explain_it_comes_after_that_it_is_too_few() -> None:
    said = verdict_sentence(reported(used=1, verdict="effect", effects=["finite-contact"]))
    assert said.startswith("nylon: 1 shot is too few to tell what is missing")
    assert said.endswith("finite-contact would explain it as well.")
