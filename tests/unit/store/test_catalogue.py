"""Shots and keys: claimed once, moved along the table, never lost."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Never

import pytest

from rigctl.errors import KeyReusedError, KeyRunningError, NotFoundError, StoreError
from rigctl.store import Change, Fired, NewShot, ShotRecord, ShotState, Store, reading

WAYS = {
    ShotState.ACCEPTED: [],
    ShotState.FIRING: ["firing"],
    ShotState.CAPTURING: ["firing", "capturing"],
    ShotState.STORED: ["firing", "capturing", "stored"],
    ShotState.ANALYSING: ["firing", "capturing", "stored", "analysing"],
    ShotState.ANALYSED: ["firing", "capturing", "stored", "analysing", "analysed"],
    ShotState.REFUSED: ["firing", "capturing", "stored", "analysing", "refused"],
    ShotState.MISFIRE: ["firing", "misfire"],
    ShotState.UNKNOWN_OUTCOME: ["firing", "unknown_outcome"],
    ShotState.ABORTED: ["aborted"],
    ShotState.INTERRUPTED: ["interrupted"],
}

ALLOWED = {
    ("accepted", "firing"),
    ("accepted", "aborted"),
    ("accepted", "interrupted"),
    ("firing", "capturing"),
    ("firing", "misfire"),
    ("firing", "unknown_outcome"),
    ("firing", "aborted"),
    ("capturing", "stored"),
    ("capturing", "aborted"),
    ("capturing", "interrupted"),
    ("stored", "analysing"),
    ("analysing", "analysed"),
    ("analysing", "refused"),
    ("analysing", "stored"),
    ("analysed", "analysing"),
    ("refused", "analysing"),
}


def led_to(store: Store, shot: ShotRecord, state: ShotState) -> None:
    for step in WAYS[state]:
        store.move(shot.id, ShotState(step))


def test_a_shot_is_named_by_date_and_number(accepted: Callable[..., ShotRecord]) -> None:
    assert accepted().id == "20260131-000001"


def test_numbers_rise_through_restarts(
    store: Store,
    accepted: Callable[..., ShotRecord],
    new_shot: Callable[..., NewShot],
) -> None:
    first = accepted("one")
    store.close()
    again = Store(store.path, database=store.address)
    second, _ = again.accept("two", "body", new_shot)
    again.close()
    assert second.number == first.number + 1


def test_a_record_holds_what_was_given(
    accepted: Callable[..., ShotRecord], new_shot: Callable[..., NewShot], store: Store
) -> None:
    record = store.shot(accepted(note="seven words").id)
    given = new_shot()
    assert record.settings == given.settings
    assert record.accepted_at == given.accepted_at
    assert (record.state, record.outcome, record.fired) == (ShotState.ACCEPTED, None, Fired.NO)
    assert (record.campaign, record.note, record.actor) == ("nylon", "seven words", "anna")


def test_fifty_threads_with_one_key_make_one_shot(
    tmp_path: Path, new_shot: Callable[..., NewShot]
) -> None:
    store = Store(tmp_path / "many", busy_timeout_s=30.0)
    start = threading.Barrier(50, timeout=120)
    outcomes = []

    def claim() -> None:
        start.wait()
        try:
            outcomes.append(store.accept("same", "body", new_shot)[1])
        except KeyRunningError:
            outcomes.append("running")

    threads = [threading.Thread(target=claim) for _ in range(50)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120)
    assert outcomes.count(False) == 1
    assert outcomes.count("running") == 49
    assert len(store.shots()) == 1
    store.close()


def test_a_key_answers_with_its_shot_once_that_has_ended(
    store: Store, accepted: Callable[..., ShotRecord], new_shot: Callable[..., NewShot]
) -> None:
    shot = accepted("key")
    with pytest.raises(KeyRunningError, match=shot.id):
        store.accept("key", "body", new_shot)
    store.move(shot.id, ShotState.ABORTED)
    record, known = store.accept("key", "body", new_shot)
    assert (record.id, known, record.outcome) == (shot.id, True, ShotState.ABORTED)


def test_a_key_with_another_body_is_refused_at_any_time(
    store: Store, accepted: Callable[..., ShotRecord], new_shot: Callable[..., NewShot]
) -> None:
    shot = accepted("key")
    for end in (None, ShotState.ABORTED):
        if end:
            store.move(shot.id, end)
        with pytest.raises(KeyReusedError, match="another body"):
            store.accept("key", "other", new_shot)


def test_a_request_that_cannot_be_described_leaves_the_key_free(
    store: Store, new_shot: Callable[..., NewShot]
) -> None:
    def refuse() -> Never:
        raise ValueError("no token")

    with pytest.raises(ValueError, match="no token"):
        store.accept("key", "body", refuse)
    assert store.shots() == []
    assert store.accept("key", "body", new_shot)[1] is False


@pytest.mark.parametrize("before", list(ShotState))
def test_a_shot_moves_along_the_table_and_not_otherwise(
    store: Store, accepted: Callable[..., ShotRecord], before: ShotState
) -> None:
    for after in ShotState:
        shot = accepted(f"to {after}")
        led_to(store, shot, before)
        if (before, after) in ALLOWED:
            assert store.move(shot.id, after).state is after
        else:
            with pytest.raises(StoreError, match=f"is {before} cannot become {after}"):
                store.move(shot.id, after)
            assert store.shot(shot.id).state is before


def test_the_outcome_is_the_first_state_in_which_the_rig_is_done(
    store: Store, accepted: Callable[..., ShotRecord]
) -> None:
    shot = accepted()
    led_to(store, shot, ShotState.ANALYSED)
    assert store.shot(shot.id).outcome is ShotState.STORED


def test_another_analysis_forgets_the_failure_of_the_one_before(
    store: Store, accepted: Callable[..., ShotRecord]
) -> None:
    shot = accepted()
    led_to(store, shot, ShotState.ANALYSING)
    failed = store.move(shot.id, ShotState.REFUSED, Change(failure="blurred", failure_code="x"))
    assert failed.failure == "blurred"
    again = store.move(shot.id, ShotState.ANALYSING)
    assert (again.failure, again.failure_code) == (None, None)


def test_what_becomes_known_is_kept_and_nothing_else_changes(
    store: Store, accepted: Callable[..., ShotRecord]
) -> None:
    shot = accepted()
    at = datetime(2026, 2, 1, tzinfo=UTC)
    store.move(shot.id, ShotState.FIRING, Change(fired=Fired.UNKNOWN))
    record = store.move(shot.id, ShotState.CAPTURING, Change(fired=Fired.YES, fired_at=at))
    assert (record.fired, record.fired_at, record.note) == (Fired.YES, at, shot.note)


def test_shots_are_listed_by_campaign_and_state_page_by_page(
    store: Store, accepted: Callable[..., ShotRecord]
) -> None:
    names = [accepted(str(i), campaign="ab"[i % 2]).id for i in range(6)]
    store.move(names[2], ShotState.ABORTED)
    assert [s.id for s in store.shots(campaign="a")] == names[::2]
    assert [s.id for s in store.shots(state=ShotState.ABORTED)] == [names[2]]
    assert [s.id for s in store.shots(limit=2)] == names[:2]
    assert [s.id for s in store.shots(limit=2, after=names[1])] == names[2:4]
    assert [s.id for s in store.catalogue.latest(2)] == names[:3:-1]
    assert [s.id for s in store.catalogue.latest(2, "a")] == [names[4], names[2]]


@pytest.mark.parametrize("name", ["20260131-000009", "x", "", "../../etc"])
def test_a_shot_that_is_not_there_is_not_found(store: Store, name: str) -> None:
    with pytest.raises(NotFoundError):
        store.shot(name)
    with pytest.raises(NotFoundError):
        store.shots(after=name)
    with pytest.raises(NotFoundError):
        store.move(name, ShotState.FIRING)


def test_listeners_hear_of_each_step_after_it_is_on_disk(
    store: Store, accepted: Callable[..., ShotRecord]
) -> None:
    heard = []

    def listen(record: ShotRecord) -> None:
        with reading(store.path, store.address) as other:
            on_disk = str(other.catalogue.shot(record.id).state)
        heard.append((str(record.state), on_disk))

    remove = store.listeners.add(listen)
    shot = accepted()
    store.move(shot.id, ShotState.FIRING)
    remove()
    store.move(shot.id, ShotState.CAPTURING)
    assert heard == [("accepted", "accepted"), ("firing", "firing")]


def test_a_listener_that_fails_harms_nobody(
    store: Store, accepted: Callable[..., ShotRecord]
) -> None:
    heard = []

    def fail(record: ShotRecord) -> Never:
        raise RuntimeError("listener")

    store.listeners.add(fail)
    store.listeners.add(lambda record: heard.append(record.id))
    assert heard == [accepted().id]
