"""One shot: the one safe order, at most one fire command, and a state for every failure."""

from __future__ import annotations

import itertools
import sqlite3
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rig_fakes import BOUND_S, FakeTrigger, Laboratory, stack

from rigctl.devices.roles import FireOutcome
from rigctl.errors import (
    DeviceAnswerError,
    DeviceSilentError,
    FireOutcomeUnknownError,
    FramesError,
    IdempotencyError,
    KeyReusedError,
    KeyRunningError,
    RecordingNotConfirmedError,
    RefusedError,
    RigError,
)


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data")
    yield laboratory
    laboratory.close()


def on_disk(lab: Laboratory) -> tuple[str, str]:
    """Return the shot's state as another program reads it from the file."""
    file = sqlite3.connect(lab.folder / "catalogue.db")
    row = file.execute("SELECT state, fired FROM shots ORDER BY number DESC").fetchone()
    file.close()
    return row


def test_everything_happens_in_the_one_safe_order(lab: Laboratory) -> None:
    token = lab.arm()
    lab.log.clear()
    lab.fire(token)
    assert lab.log == [
        "capture.start",
        "regulator.pressure",
        "slide.position",
        "trigger.check",
        "trigger.powered",
        "cut_off.check",
        "trigger.arm",
        "trigger.fire",
        "capture.mark",
        "capture.collect",
        "capture.stop",
        "trigger.make_safe",
    ]


def test_intent_is_on_disk_before_the_byte_and_the_outcome_before_the_frames(
    lab: Laboratory,
) -> None:
    seen = {}
    lab.capture.hooks["start"] = lambda: seen.update(start=on_disk(lab))
    lab.trigger.hooks["fire"] = lambda: seen.update(fire=on_disk(lab))
    lab.capture.hooks["mark"] = lambda: seen.update(mark=on_disk(lab))
    lab.capture.hooks["collect"] = lambda: seen.update(collect=on_disk(lab))
    lab.capture.hooks["stop"] = lambda: seen.update(stop=on_disk(lab))
    lab.shoot()
    assert seen == {
        "start": ("accepted", "no"),
        "fire": ("firing", "unknown"),
        "mark": ("firing", "unknown"),
        "collect": ("capturing", "yes"),
        "stop": ("stored", "yes"),
    }


def test_the_mark_is_told_how_late_it_comes_after_the_fire_command(lab: Laboratory) -> None:
    lab.trigger.hooks["fire"] = lambda: lab.time.pass_time(0.004)
    shot = lab.shoot()
    assert lab.capture.marked_late_s == pytest.approx(0.004)
    assert lab.store.folders.manifest(shot.id)["trigger"]["answer_time_s"] == pytest.approx(0.004)


def test_the_row_says_stored_only_when_the_folder_is_whole(lab: Laboratory) -> None:
    whole = []
    lab.store.listeners.add(
        lambda shot: whole.append((str(shot.state), lab.store.folders.is_whole(shot.id)))
    )
    lab.shoot()
    assert dict(whole) == {
        "accepted": False,
        "firing": False,
        "capturing": False,
        "stored": True,
    }


def test_a_stored_shot_has_its_frames_and_a_manifest_with_units(lab: Laboratory) -> None:
    shot = lab.shoot()
    np.testing.assert_array_equal(lab.store.frames(shot.id).pixels, stack().pixels)
    manifest = lab.store.folders.manifest(shot.id)
    assert manifest["settings"]["pressure_a_kpa"] == 40.0
    assert manifest["configuration"]["sha256"] == lab.configuration.digest
    assert manifest["simulated"] is True
    assert manifest["trigger"] == {
        "sequence": shot.number,
        "answer_time_s": 0.0,
        "device_time_us": 123,
    }
    assert (shot.frames, shot.lost) == (4, 0)
    assert lab.to_analyse == [shot.id]


def test_lost_frames_are_counted_in_the_record(lab: Laboratory) -> None:
    lab.capture.lost = (17, 18)
    assert lab.shoot().lost == 2


def test_the_sequence_number_is_the_shots_and_rises_through_restarts(lab: Laboratory) -> None:
    for _ in range(2):
        lab.shoot()
        lab.start_again()
    lab.shoot()
    assert lab.trigger.fired == [1, 2, 3]


def test_every_step_is_journalled_and_told(lab: Laboratory) -> None:
    told = []
    lab.rig.listeners.add(lambda step: told.append((str(step.before), str(step.after))))
    lab.shoot()
    way = ["idle", "checked", "armed", "firing", "capturing", "stored", "idle"]
    assert told == list(itertools.pairwise(way))
    assert lab.journalled()[-6:] == told
    assert lab.store.journal.verify() == 7


FAILURES = [
    # where, error, shot's state, fired, rig's state, fire commands
    ("capture.start", RecordingNotConfirmedError("no tape"), "aborted", "no", "idle", 0),
    ("capture.start", DeviceSilentError("no recorder"), "aborted", "no", "fault", 0),
    ("capture.start", ZeroDivisionError("a bug"), "aborted", "no", "fault", 0),
    ("trigger.arm", DeviceAnswerError("out of range"), "aborted", "no", "fault", 0),
    ("trigger.fire", DeviceAnswerError("no power"), "misfire", "no", "idle", 1),
    ("trigger.fire", FireOutcomeUnknownError("?"), "unknown_outcome", "unknown", None, 1),
    ("trigger.fire", DeviceSilentError("?"), "unknown_outcome", "unknown", None, 1),
    ("trigger.fire", OSError("?"), "unknown_outcome", "unknown", None, 1),
    ("capture.mark", FramesError("no marker"), "aborted", "yes", "idle", 1),
    ("capture.collect", FramesError("no frames came"), "aborted", "yes", "idle", 1),
    ("capture.collect", DeviceSilentError("no recorder"), "aborted", "yes", "fault", 1),
    ("capture.stop", DeviceSilentError("tape runs on"), "stored", "yes", "fault", 1),
    ("trigger.make_safe", DeviceSilentError("no answer"), "stored", "yes", "fault", 1),
]


@pytest.mark.parametrize("case", FAILURES, ids=lambda case: f"{case[0]} {case[1]}")
def test_each_failure_has_its_state_and_ends_safe(lab: Laboratory, case: tuple[Any, ...]) -> None:
    where, error, state, fired, rig, fires = case
    token = lab.arm()
    role, call = where.split(".")
    getattr(lab, role).errors[call] = error
    shot = lab.fire(token)
    assert (shot.state, shot.outcome, shot.fired) == (state, state, fired)
    assert lab.state == (rig or "unknown_outcome")
    assert len(lab.trigger.fired) == fires
    assert lab.log[-2:] == ["capture.stop", "trigger.make_safe"]
    if state != "stored":
        assert str(error) in shot.failure
    getattr(lab, role).errors.clear()
    if lab.state != "idle":
        lab.rig.release("anna", "looked at it")
    assert lab.shoot().state == "stored"


def test_frames_that_cannot_be_written_are_a_fault_that_says_so(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    token = lab.arm()

    def full() -> None:
        monkeypatch.setattr(np, "save", lambda *a, **k: (_ for _ in ()).throw(OSError(28, "full")))

    lab.capture.hooks["collect"] = full
    shot = lab.fire(token)
    assert (shot.state, shot.fired, shot.failure_code) == ("aborted", "yes", "store")
    assert lab.state == "fault"


def test_an_outcome_that_cannot_be_stored_leaves_the_outcome_unknown(lab: Laboratory) -> None:
    token = lab.arm()
    holders = []

    def lock() -> None:
        holder = sqlite3.connect(lab.folder / "catalogue.db", isolation_level=None)
        holder.execute("BEGIN IMMEDIATE")
        holders.append(holder)

    lab.trigger.hooks["fire"] = lock
    lab.fire(token)
    assert lab.state == "unknown_outcome"
    holders[0].execute("ROLLBACK")
    holders[0].close()
    assert on_disk(lab) == ("firing", "unknown")
    lab.trigger.hooks.clear()
    lab.restart()
    assert lab.state == "unknown_outcome"
    assert on_disk(lab) == ("unknown_outcome", "unknown")
    assert lab.trigger.fired == [1]


class TriggerThatRemembers(FakeTrigger):
    """Can be asked afterwards what became of a fire command."""

    answer = FireOutcome.UNKNOWN

    def outcome(self, sequence: int) -> FireOutcome:
        self.called(f"outcome {sequence}")
        return self.answer


@pytest.mark.parametrize(
    ("answer", "state", "rig"),
    [
        (FireOutcome.FIRED, "stored", "idle"),
        (FireOutcome.NOT_FIRED, "misfire", "idle"),
        (FireOutcome.UNKNOWN, "unknown_outcome", "unknown_outcome"),
    ],
)
def test_a_trigger_that_remembers_settles_a_lost_answer_without_firing_again(
    tmp_path: Path, answer: FireOutcome, state: str, rig: str
) -> None:
    lab = Laboratory(tmp_path / "data")
    lab.trigger.__class__ = TriggerThatRemembers
    lab.trigger.answer = answer
    token = lab.arm()
    lab.trigger.errors["fire"] = FireOutcomeUnknownError("no answer")
    assert lab.fire(token).state == state
    assert lab.state == rig
    assert lab.trigger.fired == [1]
    assert lab.log.count("trigger.outcome 1") == 1
    lab.close()


def test_a_query_that_fails_leaves_the_outcome_unknown(tmp_path: Path) -> None:
    lab = Laboratory(tmp_path / "data")
    lab.trigger.__class__ = TriggerThatRemembers
    token = lab.arm()
    lab.trigger.errors |= {"fire": FireOutcomeUnknownError("?"), "outcome 1": OSError("gone")}
    assert lab.fire(token).state == "unknown_outcome"
    lab.close()


def test_an_unknown_outcome_is_ended_by_a_person_with_a_reason(lab: Laboratory) -> None:
    token = lab.arm()
    lab.trigger.errors["fire"] = FireOutcomeUnknownError("?")
    lab.fire(token)
    with pytest.raises(RefusedError, match="unknown_outcome"):
        lab.arm()
    for nothing in ("", "  "):
        with pytest.raises(RefusedError, match="reason"):
            lab.rig.release("anna", nothing)
    lab.rig.release("anna", "both spheres lie in the tray")
    assert lab.state == "idle"
    entry = lab.store.journal.last()
    assert (entry.actor, entry.reason) == ("anna", "both spheres lie in the tray")


def test_a_key_fires_once_and_then_answers_with_its_shot(lab: Laboratory) -> None:
    first = lab.fire(lab.arm(), key="mine")
    lab.time.pass_time(1.0)
    again = lab.fire(lab.arm(), key="mine")
    assert again.id == first.id
    assert lab.trigger.fired == [1]
    assert lab.state == "armed"
    with pytest.raises(KeyReusedError):
        lab.fire(lab.arm(), key="mine", body="other")


def test_the_stored_answer_of_a_failed_shot_is_its_failure(lab: Laboratory) -> None:
    token = lab.arm()
    lab.trigger.errors["fire"] = DeviceAnswerError("no power")
    lab.fire(token, key="mine")
    lab.trigger.errors.clear()
    again = lab.fire("whatever", key="mine")
    assert (again.outcome, again.failure) == ("misfire", "no power")
    assert lab.trigger.fired == [1]


@pytest.mark.parametrize("key", ["", "   "])
def test_without_a_key_nothing_is_accepted(lab: Laboratory, key: str) -> None:
    token = lab.arm()
    with pytest.raises(IdempotencyError, match="empty"):
        lab.fire(token, key=key)
    assert lab.store.shots() == []


def test_fifty_threads_with_one_key_fire_once(tmp_path: Path) -> None:
    lab = Laboratory(tmp_path / "data", threads=True)
    token = lab.arm()
    release = threading.Event()
    lab.trigger.hooks["fire"] = lambda: release.wait(BOUND_S)
    start = threading.Barrier(50, timeout=BOUND_S)
    answers = []

    def post() -> None:
        start.wait()
        try:
            answers.append(lab.rig.accept(token, "same", "body", actor="anna").id)
        except RigError as error:
            answers.append(type(error))

    threads = [threading.Thread(target=post) for _ in range(50)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(BOUND_S)
    release.set()
    shot = lab.rig.wait("20260131-000001", BOUND_S)
    assert shot.outcome == "stored"
    assert answers.count("20260131-000001") == 1
    assert answers.count(KeyRunningError) == 49
    assert lab.trigger.fired == [1]
    lab.close()


def test_accept_returns_while_the_shot_is_under_way_and_nothing_else_starts(tmp_path: Path) -> None:
    lab = Laboratory(tmp_path / "data", threads=True)
    token = lab.arm()
    reached, go_on = threading.Event(), threading.Event()

    def block() -> None:
        reached.set()
        go_on.wait(BOUND_S)

    lab.trigger.hooks["fire"] = block
    shot = lab.rig.accept(token, "mine", "body", actor="anna")
    assert shot.outcome is None
    assert reached.wait(BOUND_S)
    assert lab.rig.status().running == shot.id
    with pytest.raises(RefusedError, match=f"firing.*{shot.id}"):
        lab.arm()
    with pytest.raises(KeyRunningError):
        lab.rig.accept("other", "mine", "body", actor="anna")
    assert lab.rig.wait(shot.id, 0.0).outcome is None
    go_on.set()
    assert lab.rig.wait(shot.id, BOUND_S).outcome == "stored"
    assert lab.trigger.fired == [1]
    lab.close()


def test_arming_right_after_a_shot_is_stored_waits_for_the_safe_state(tmp_path: Path) -> None:
    lab = Laboratory(tmp_path / "data", threads=True)
    token = lab.arm()
    stopping, go_on = threading.Event(), threading.Event()

    def block() -> None:
        stopping.set()
        go_on.wait(BOUND_S)

    lab.capture.hooks["stop"] = block
    lab.rig.accept(token, "mine", "body", actor="anna")
    assert stopping.wait(BOUND_S)
    assert lab.state == "stored"
    armed = []
    thread = threading.Thread(target=lambda: armed.append(lab.arm()))
    thread.start()
    go_on.set()
    thread.join(BOUND_S)
    assert len(armed) == 1
    assert lab.state == "armed"
    lab.close()
