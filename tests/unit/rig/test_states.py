"""The table of transitions, against a list written by hand."""

from __future__ import annotations

import itertools

import pytest

from rigctl.errors import RefusedError
from rigctl.rig.states import LATCHED, RigState, require_move

BY_ITSELF = {
    ("idle", "checked"),
    ("idle", "fault"),
    ("checked", "armed"),
    ("checked", "idle"),
    ("checked", "fault"),
    ("armed", "firing"),
    ("armed", "idle"),
    ("armed", "fault"),
    ("firing", "capturing"),
    ("firing", "aborted"),
    ("firing", "misfire"),
    ("firing", "unknown_outcome"),
    ("capturing", "stored"),
    ("capturing", "aborted"),
    ("stored", "idle"),
    ("stored", "fault"),
    ("aborted", "idle"),
    ("aborted", "fault"),
    ("misfire", "idle"),
    ("misfire", "fault"),
    *((str(state), "estop") for state in RigState),
}
BY_A_PERSON = {("unknown_outcome", "idle"), ("fault", "idle"), ("estop", "idle")}
PAIRS = list(itertools.product(RigState, RigState))


@pytest.mark.parametrize(("before", "after"), PAIRS)
def test_the_rig_moves_by_itself_only_along_the_table(before: RigState, after: RigState) -> None:
    if (before, after) in BY_ITSELF:
        require_move(before, after)
    else:
        with pytest.raises(RefusedError):
            require_move(before, after)


@pytest.mark.parametrize(("before", "after"), PAIRS)
def test_a_persons_reason_opens_the_latched_states_and_nothing_else(
    before: RigState, after: RigState
) -> None:
    if (before, after) in BY_ITSELF | BY_A_PERSON:
        require_move(before, after, released=True)
    else:
        with pytest.raises(RefusedError):
            require_move(before, after, released=True)


def test_unknown_outcome_fault_and_estop_are_latched() -> None:
    assert {"unknown_outcome", "fault", "estop"} == LATCHED


def test_the_only_way_to_fire_is_from_armed() -> None:
    assert [b for b, a in BY_ITSELF | BY_A_PERSON if a == "firing"] == ["armed"]
