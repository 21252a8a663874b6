"""How far a first visit has come, from what lies in the store."""

from __future__ import annotations

from datetime import UTC, datetime
from types import SimpleNamespace
from typing import Any

import pytest

from analysis.model.verdict.standing import Word
from rigctl.config import Limits
from rigctl.page.guide.rail import (
    COMPARE,
    COMPARED,
    FIRE,
    OVER,
    READ,
    SWEEP,
    Found,
    first_words,
    progress_of,
)
from rigctl.page.model.pages import found_of
from rigctl.page.sweeps.broad import broad_sweep
from rigctl.rig.states import RigState
from rigctl.store import CampaignRecord, ShotState
from rigctl.sweeps.plan import plan_of, require_possible

AT = datetime(2026, 1, 1, tzinfo=UTC)


def campaign(name: str, measured: int, refused: int = 0) -> CampaignRecord:
    states = {ShotState.ANALYSED: measured, ShotState.REFUSED: refused}
    return CampaignRecord(name, {state: count for state, count in states.items() if count}, AT, AT)


def test_an_empty_store_asks_for_a_shot() -> None:
    assert progress_of([], any_measured=False).step == FIRE


@pytest.mark.parametrize("refused", [1, 2, 9])
def test_refused_shots_alone_are_nothing_to_read_or_sweep(refused: int) -> None:
    known = [campaign("first", 0, refused)]
    assert progress_of(known, any_measured=False).step == FIRE


@pytest.mark.parametrize(
    ("measured", "step"), [(1, READ), (2, SWEEP), (19, SWEEP), (20, COMPARE), (120, COMPARE)]
)
def test_measured_shots_lead_on(measured: int, step: int) -> None:
    found = progress_of([campaign("first", measured)], any_measured=True)
    assert (found.step, found.campaign, found.measured) == (step, "first", measured)


def test_the_campaign_with_most_measured_shots_is_the_one_that_is_compared() -> None:
    known = [campaign("small", 3, 90), campaign("large", 40), campaign("other", 5)]
    assert progress_of(known, any_measured=True).campaign == "large"


@pytest.mark.parametrize(
    ("word", "added", "step", "said"),
    [
        (Word.MISSING, False, COMPARE, "add it, and the error falls"),
        (Word.MISSING, True, COMPARE, "Something more is still missing"),
        (Word.FLOOR, True, OVER, "found and added"),
        (Word.ALIKE, True, OVER, "found and added"),
        (Word.FLOOR, False, OVER, "what these shots show"),
        (Word.UNEXPLAINED, True, OVER, "what these shots show"),
    ],
)
def test_the_last_step_is_done_once_nothing_is_left_to_add(
    word: Word, added: bool, step: int, said: str
) -> None:
    found = found_of(word, added=added)
    assert progress_of([], any_measured=False, found=found).step == step
    assert said in COMPARED[found]


@pytest.mark.parametrize(
    ("state", "shot", "said"),
    [
        (RigState.IDLE, None, "press Arm, then Fire"),
        (RigState.ARMED, None, "now press Fire"),
        (RigState.CAPTURING, ShotState.CAPTURING, "the spheres fly"),
        (RigState.IDLE, ShotState.ANALYSING, "Its pictures are measured now"),
        (RigState.IDLE, ShotState.REFUSED, "what helps, stands with its film"),
    ],
)
def test_the_guide_says_what_is_done_with_the_first_shot_just_now(
    state: RigState, shot: ShotState | None, said: str
) -> None:
    status: Any = SimpleNamespace(
        state=state, last_shot=None if shot is None else SimpleNamespace(state=shot)
    )
    assert said in first_words(status)


@pytest.mark.parametrize(("fired_here", "done"), [(True, [1, 2, 3, 4]), (False, [4])])
def test_steps_that_nobody_took_here_are_not_called_done(fired_here: bool, done: list[int]) -> None:
    over = progress_of([], any_measured=fired_here, found=Found.ENDED)
    assert [step for step in range(1, 5) if over.is_done(step)] == done


def test_a_shot_without_a_campaign_is_read_too() -> None:
    assert progress_of([], any_measured=True).step == READ


def limits(**ranges: tuple[float, float]) -> Limits:
    common = {"pressure_kpa": (5, 120), "offset_mm": (0, 24), "delay_us": (0, 0), **ranges}
    return Limits.model_validate(
        {
            **common,
            "pressure_tolerance_kpa": 0.5,
            "offset_tolerance_mm": 0.02,
            "settle_timeout_s": 20,
            "reading_max_age_s": 2,
            "arm_lifetime_s": 30,
            "cool_down_s": 1,
            "free_disk_mb": 100,
        }
    )


def test_thirty_shots_are_thirty_that_the_rig_can_fire() -> None:
    narrow = limits(pressure_kpa=(30, 60), offset_mm=(0, 12))
    for allowed in (limits(), narrow):
        sweep = broad_sweep("first", allowed)
        assert sweep is not None
        assert sweep.count() == 30
        require_possible(plan_of(sweep), allowed)


def test_a_rig_without_a_slide_is_given_no_grid() -> None:
    assert broad_sweep("first", limits(offset_mm=(0, 0))) is None
