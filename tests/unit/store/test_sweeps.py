"""The table of sweeps and steps: durable, at most once, and strict about what follows what."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from rigctl.errors import KeyReusedError, NotFoundError, StoreError
from rigctl.settings import ShotSettings
from rigctl.store import NewSweep, ShotRecord, StepState, Store, SweepRecord, SweepState
from tests.unit.store.conftest import sqlite_alone

NOW = datetime(2026, 1, 31, 12, 0, tzinfo=UTC)


def settings(offset: float = 6.0) -> ShotSettings:
    return ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=41.0, offset_mm=offset)


def new_sweep(steps: int = 3) -> NewSweep:
    wanted = tuple(settings(float(k % 100)) for k in range(steps))
    return NewSweep(wanted, '{"asked": "for"}', "{}", "nylon", "anna", NOW)


@pytest.fixture
def sweep(store: Store) -> SweepRecord:
    return store.sweeps.accept("key", "body", new_sweep)[0]


def test_a_sweep_is_created_with_its_steps_in_order_and_running(
    store: Store, sweep: SweepRecord
) -> None:
    assert (sweep.id, sweep.state, sweep.steps) == ("20260131-s0001", SweepState.RUNNING, 3)
    assert [step.settings.offset_mm for step in store.sweeps.steps(sweep.id)] == [0.0, 1.0, 2.0]
    assert store.sweeps.sweep(sweep.id) == sweep


def test_the_same_key_gives_the_same_sweep_and_another_body_is_refused(
    store: Store, sweep: SweepRecord
) -> None:
    assert store.sweeps.accept("key", "body", new_sweep) == (sweep, True)
    with pytest.raises(KeyReusedError, match="another body"):
        store.sweeps.accept("key", "other", new_sweep)
    assert len(store.sweeps.sweeps()) == 1


def test_what_refuses_the_description_leaves_the_key_free(store: Store) -> None:
    def refuse() -> NewSweep:
        raise NotFoundError("no")

    with pytest.raises(NotFoundError):
        store.sweeps.accept("key", "body", refuse)
    assert not store.sweeps.accept("key", "other", new_sweep)[1]


def test_a_step_is_taken_once_and_ends_once(
    store: Store, sweep: SweepRecord, accepted: Callable[..., ShotRecord]
) -> None:
    step = store.sweeps.take(sweep.id, 1, NOW)
    assert (step.state, step.attempt) == (StepState.TAKEN, 1)
    with pytest.raises(StoreError, match="taken cannot become taken"):
        store.sweeps.take(sweep.id, 1, NOW)
    shot = accepted(str(step.key))
    done = store.sweeps.end(sweep.id, 1, StepState.STORED, NOW, shot=shot.id)
    assert (done.shot, done.ended_at) == (shot.id, NOW)
    for again in StepState:
        with pytest.raises(StoreError):
            store.sweeps.end(sweep.id, 1, again, NOW)
    waiting = store.sweeps.next_step(sweep.id)
    assert waiting is not None
    assert waiting.number == 2


def test_the_shot_of_a_step_is_found_by_the_key_that_was_taken(
    store: Store, sweep: SweepRecord, accepted: Callable[..., ShotRecord]
) -> None:
    step = store.sweeps.take(sweep.id, 2, NOW)
    assert store.catalogue.of_key(str(step.key)) is None
    shot = accepted(str(step.key))
    assert store.catalogue.of_key(str(step.key)) == shot


def test_two_steps_never_share_a_shot(
    store: Store, sweep: SweepRecord, accepted: Callable[..., ShotRecord]
) -> None:
    shot = accepted()
    for step in (1, 2):
        store.sweeps.take(sweep.id, step, NOW)
    store.sweeps.end(sweep.id, 1, StepState.STORED, NOW, shot=shot.id)
    with pytest.raises(StoreError, match=r"(?i)unique"):
        store.sweeps.end(sweep.id, 2, StepState.STORED, NOW, shot=shot.id)


def test_only_steps_that_certainly_did_not_fly_wait_again_after_a_resume(
    store: Store, sweep: SweepRecord
) -> None:
    ends = (StepState.NOT_FIRED, StepState.UNKNOWN, StepState.LOST)
    taken = store.sweeps.take(sweep.id, 1, NOW)
    for number, state in enumerate(ends, start=1):
        if number > 1:
            store.sweeps.take(sweep.id, number, NOW)
        store.sweeps.end(sweep.id, number, state, NOW)
    store.sweeps.move(sweep.id, SweepState.PAUSED, "a fault", NOW)
    assert store.sweeps.next_step(sweep.id) is None
    store.sweeps.move(sweep.id, SweepState.RUNNING, "resumed", NOW)
    assert [step.state for step in store.sweeps.steps(sweep.id)] == [
        StepState.WAITING,
        StepState.UNKNOWN,
        StepState.LOST,
    ]
    first, again = taken.key, store.sweeps.take(sweep.id, 1, NOW)
    assert again.attempt == 2
    # Nobody can tell a key beforehand: each has 192 random bits.
    assert len({first, again.key}) == 2
    assert all(len(str(key)) == 32 for key in (first, again.key))


def test_the_end_of_a_sweep_skips_what_waits(store: Store, sweep: SweepRecord) -> None:
    store.sweeps.take(sweep.id, 1, NOW)
    store.sweeps.end(sweep.id, 1, StepState.LOST, NOW)
    later = NOW + timedelta(hours=1)
    ended = store.sweeps.move(sweep.id, SweepState.ABORTED, "enough", later)
    assert ended.counts == {StepState.LOST: 1, StepState.SKIPPED: 2}
    assert (ended.reason, ended.ended_at) == ("enough", later)
    with pytest.raises(StoreError, match="aborted cannot become running"):
        store.sweeps.move(sweep.id, SweepState.RUNNING, "again", later)


def test_sweeps_are_listed_latest_first_page_by_page(store: Store) -> None:
    for key in "abc":
        store.sweeps.accept(key, "body", new_sweep)
    store.sweeps.move("20260131-s0002", SweepState.PAUSED, "a word", NOW)
    assert [one.number for one in store.sweeps.sweeps(limit=2)] == [3, 2]
    assert [one.number for one in store.sweeps.sweeps(before="20260131-s0002")] == [1]
    assert [one.number for one in store.sweeps.sweeps(state=SweepState.PAUSED)] == [2]
    with pytest.raises(NotFoundError, match="no such sweep"):
        store.sweeps.sweep("20260131-s0009")


@sqlite_alone
def test_a_catalogue_that_another_program_locks_leaves_no_part_of_a_sweep(
    store: Store, tmp_path: Path
) -> None:
    holder = sqlite3.connect(tmp_path / "data" / "catalogue.db", isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")
    with pytest.raises(StoreError, match=r"locked.*end the program"):
        store.sweeps.accept("key", "body", new_sweep)
    holder.execute("ROLLBACK")
    holder.close()
    assert store.sweeps.sweeps() == []
    assert store.sweeps.accept("key", "body", new_sweep)[0].steps == 3


@sqlite_alone
def test_a_sweep_that_does_not_fit_on_the_disk_leaves_no_part_of_itself(store: Store) -> None:
    with store._database.reading() as connection:
        pages = connection.exec_driver_sql("PRAGMA page_count").scalar_one()
        connection.exec_driver_sql(f"PRAGMA max_page_count = {pages}")
    with pytest.raises(StoreError, match=r"full.*free disk space"):
        store.sweeps.accept("key", "body", lambda: new_sweep(5000))
    assert store.sweeps.sweeps() == []
