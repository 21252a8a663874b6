"""The audit holds every step: first on the way to a shot, at the latest possible moment back."""

from __future__ import annotations

import sqlite3
from datetime import UTC, datetime
from pathlib import Path

import pytest
from rig_fakes import Laboratory

from rigctl.errors import StoreError
from rigctl.rig.standing import AFTER_STOP, Logbook
from rigctl.rig.states import TOWARD_FIRE, RigState
from rigctl.rig.status import Transition

AT = datetime(2026, 1, 31, tzinfo=UTC)


class Journal:
    """Keeps entries in memory; `full` is a disk that refuses."""

    def __init__(self) -> None:
        self.entries = []
        self.full = False

    def append(self, **entry: object) -> None:
        if self.full:
            raise StoreError("the disk is full")
        self.entries.append(entry["reason"])


def step(after: RigState, reason: str) -> Transition:
    return Transition(RigState.IDLE, after, AT, "anna", reason, None)


@pytest.fixture
def journal() -> Journal:
    return Journal()


@pytest.mark.parametrize("state", sorted(TOWARD_FIRE))
def test_a_step_toward_firing_is_not_taken_without_the_audit(
    journal: Journal, state: RigState
) -> None:
    journal.full = True
    with pytest.raises(StoreError):
        Logbook(journal).write(step(state, "first"))


@pytest.mark.parametrize("state", sorted(set(RigState) - TOWARD_FIRE))
def test_a_step_toward_safety_is_taken_and_written_later_in_order(
    journal: Journal, state: RigState
) -> None:
    book = Logbook(journal)
    journal.full = True
    book.write(step(state, "first"))
    book.write(step(RigState.ESTOP, "second"))
    with pytest.raises(StoreError):
        book.write(step(RigState.ARMED, "never taken"))
    journal.full = False
    book.write(step(RigState.IDLE, "third"))
    assert journal.entries == ["first", "second", "third"]


def test_the_rig_stops_with_a_locked_audit_and_owes_it_the_step(tmp_path: Path) -> None:
    lab = Laboratory(tmp_path / "data")
    lab.arm()
    holder = sqlite3.connect(lab.folder / "catalogue.db", isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")
    lab.rig.estop("berta", "smoke")
    assert (lab.state, lab.cut_off.power) == ("estop", False)
    holder.execute("ROLLBACK")
    holder.close()
    lab.rig.release("berta", "only steam")
    entries = lab.store.journal.entries(limit=1000)
    steps = [(entry.before, entry.after) for entry in entries if entry.actor != AFTER_STOP]
    assert steps[-2:] == [("armed", "estop"), ("estop", "idle")]
    lab.store.journal.verify()
    lab.close()


def test_a_rig_whose_audit_is_locked_is_neither_armed_nor_fired(tmp_path: Path) -> None:
    lab = Laboratory(tmp_path / "data")
    token = lab.arm()
    holder = sqlite3.connect(lab.folder / "catalogue.db", isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")
    with pytest.raises(StoreError, match="locked"):
        lab.fire(token)
    assert lab.trigger.fired == []
    assert lab.state == "idle"
    holder.execute("ROLLBACK")
    holder.close()
    assert lab.store.shots() == []
    assert lab.shoot().state == "stored"
    lab.close()
