"""The latch of the emergency stop: it outlives the daemon, and a person with a reason ends it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Never

import pytest
from rig_fakes import BOUND_S, Blocked, Laboratory, in_thread, until

from rigctl.errors import (
    DeviceError,
    DeviceSilentError,
    RefusedError,
    StoreError,
)
from rigctl.rig.standing import AFTER_STOP
from rigctl.rig.stopping import latch
from rigctl.store.journal import Journal


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data", threads=True)
    yield laboratory
    laboratory.close()


def test_the_latch_outlives_the_daemon(lab: Laboratory) -> None:
    lab.rig.estop("berta", "smoke")
    for _ in range(2):
        lab.restart()
        assert lab.state == "estop"
        assert lab.rig.status().latch_reason == "smoke"
        assert lab.cut_off.power is False


def test_the_latch_outlives_the_loss_of_its_file_and_the_file_that_of_the_audit(
    lab: Laboratory,
) -> None:
    lab.rig.estop("berta", "smoke")
    lab.abandon()
    (lab.folder / "estop.json").unlink()
    lab.open()
    assert lab.state == "estop"
    lab.abandon()
    (lab.folder / "catalogue.db").unlink()
    lab.open()
    assert (lab.state, lab.rig.status().latch_reason) == ("estop", "smoke")


@pytest.mark.parametrize("content", ["", "{", "[]", '{"actor": "x"}', "\x00"])
def test_a_latch_file_that_cannot_be_read_counts_as_latched(lab: Laboratory, content: str) -> None:
    lab.abandon()
    (lab.folder / "estop.json").write_text(content)
    lab.open()
    assert lab.state == "estop"


def test_the_first_of_several_stops_is_kept_and_each_is_journalled(lab: Laboratory) -> None:
    lab.rig.estop("berta", "smoke")
    lab.rig.estop("carl", "fire")
    assert json.loads((lab.folder / "estop.json").read_text())["reason"] == "smoke"
    entries = lab.store.journal.entries(limit=100)
    actors = [(e.actor, e.after) for e in entries if e.actor != AFTER_STOP]
    assert actors[-2:] == [("berta", "estop"), ("carl", "estop")]


def test_of_a_thousand_stops_a_few_are_journalled_and_the_release_counts_the_others(
    lab: Laboratory,
) -> None:
    before = len(lab.store.journal.entries(limit=1000))
    for _ in range(1000):
        lab.rig.estop("berta", "smoke")
    entries = lab.store.journal.entries(limit=1000)
    assert len([e for e in entries[before:] if e.actor != AFTER_STOP]) < 10
    lab.rig.release("berta", "only steam")
    assert "994 times more" in lab.store.journal.entries(limit=1000)[-1].reason


def test_stops_that_wait_for_the_line_share_the_next_cut(lab: Laboratory) -> None:
    blocked = Blocked(lab.cut_off, "cut")
    first = in_thread(lambda: lab.rig.estop("berta", "smoke"))
    assert blocked.reached.wait(BOUND_S)
    others = [in_thread(lambda: lab.rig.estop("carl", "fire")) for _ in range(20)]
    until(lambda: lab.rig._stop._stops == 21)
    blocked.go_on.set()
    for thread in (first, *others):
        thread.join(BOUND_S)
    assert lab.log.count("cut_off.cut") == 2
    assert (lab.state, lab.cut_off.power) == ("estop", False)


def test_a_person_with_a_reason_ends_the_stop(lab: Laboratory) -> None:
    lab.rig.estop("berta", "smoke")
    lab.rig.release("berta", "only steam")
    assert (lab.state, lab.cut_off.power) == ("idle", True)
    assert not (lab.folder / "estop.json").exists()
    assert lab.rig.status().latch_reason is None
    lab.start_again()
    assert lab.state == "idle"


def test_nothing_is_released_where_nothing_is_latched(lab: Laboratory) -> None:
    with pytest.raises(RefusedError, match="nothing is to be released"):
        lab.rig.release("berta", "no need")


def test_a_stop_during_a_release_wins(lab: Laboratory) -> None:
    lab.rig.estop("berta", "smoke")
    blocked = Blocked(lab.cut_off, "restore")
    refused = []

    def release() -> None:
        with pytest.raises(RefusedError, match="stopped again"):
            lab.rig.release("berta", "only steam")
        refused.append(True)

    releasing = in_thread(release)
    assert blocked.reached.wait(BOUND_S)
    stopping = in_thread(lambda: lab.rig.estop("carl", "flames"))
    until(lambda: lab.rig._stop._stops == 2)
    blocked.go_on.set()
    releasing.join(BOUND_S)
    stopping.join(BOUND_S)
    assert refused == [True]
    assert (lab.state, lab.cut_off.power) == ("estop", False)
    assert lab.rig._stop.powered is False


def test_a_stop_between_the_return_of_power_and_the_end_of_the_release_wins(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    lab.rig.estop("berta", "smoke")
    restore = lab.rig._stop.restore

    def restore_and_stop() -> None:
        restore()
        lab.rig.estop("carl", "flames")

    monkeypatch.setattr(lab.rig._stop, "restore", restore_and_stop)
    with pytest.raises(RefusedError, match="stopped again"):
        lab.rig.release("berta", "only steam")
    assert (lab.state, lab.cut_off.power) == ("estop", False)


@pytest.mark.parametrize("part", ["trigger", "cut_off"])
def test_a_release_that_a_device_does_not_take_leaves_the_latch(lab: Laboratory, part: str) -> None:
    lab.rig.estop("berta", "smoke")
    call = "make_safe" if part == "trigger" else "restore"
    getattr(lab, part).errors[call] = DeviceSilentError("no line")
    with pytest.raises(DeviceError):
        lab.rig.release("berta", "only steam")
    assert lab.state == "estop"
    assert (lab.folder / "estop.json").exists()
    getattr(lab, part).errors.clear()


def full_disk(*_: object) -> Never:
    raise OSError(28, "No space left on device")


def test_a_full_disk_does_not_hinder_the_stop_and_the_state_says_what_is_not_written(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(latch, "write_synced", full_disk)
    lab.rig.estop("berta", "smoke")
    assert (lab.state, lab.cut_off.power) == ("estop", False)
    assert any("No space left" in warning for warning in lab.rig.status().warnings)


@pytest.mark.parametrize("end", [Laboratory.start_again, Laboratory.restart])
def test_a_stop_on_a_full_disk_outlasts_every_end_of_the_daemon(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch, end: Callable[[Laboratory], None]
) -> None:
    lab.shoot()
    with monkeypatch.context() as full:
        full.setattr(latch, "write_synced", full_disk)
        full.setattr(Journal, "append", lambda *_, **__: refuse_to_store())
        lab.rig.estop("berta", "smoke")
        lab.cut_off.power = False
        end(lab)
        assert (lab.state, lab.cut_off.power) == ("estop", False)
        with pytest.raises(RefusedError):
            lab.arm()


def refuse_to_store() -> Never:
    raise StoreError("the disk is full")


def test_the_reason_of_a_stop_is_written_once_the_disk_has_room(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(latch, "KEEP_AGAIN_S", 0.001)
    with monkeypatch.context() as full:
        full.setattr(latch, "write_synced", full_disk)
        lab.rig.estop("berta", "smoke")
        assert not (lab.folder / "estop.json").exists()
    until(lambda: not lab.rig.status().warnings)
    assert json.loads((lab.folder / "estop.json").read_text())["reason"] == "smoke"


def test_a_release_ends_the_attempts_to_write_the_reason(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(latch, "write_synced", full_disk)
    lab.rig.estop("berta", "smoke")
    lab.rig.release("berta", "only steam")
    assert (lab.state, lab.rig.status().warnings) == ("idle", ())
    assert not (lab.folder / "estop.json").exists()


def test_a_daemon_that_was_killed_comes_back_latched_and_without_power(lab: Laboratory) -> None:
    lab.shoot()
    lab.cut_off.power = False
    lab.restart()
    assert (lab.state, lab.cut_off.power) == ("estop", False)
    assert "clean end" in str(lab.rig.status().latch_reason)
    lab.restart()
    assert lab.state == "estop"
    lab.rig.release("anna", "looked at the tubes")
    assert lab.shoot().state == "stored"


def test_a_start_is_refused_where_a_kill_after_it_could_not_be_noticed(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    lab.close()
    with monkeypatch.context() as read_only:
        read_only.setattr(
            latch.Path, "unlink", lambda *_, **__: raise_os_error(30, "Read-only file system")
        )
        with pytest.raises(StoreError, match="clean end"):
            lab.open()
    lab.store.close()
    lab.open()
    assert lab.state == "idle"


def raise_os_error(number: int, what: str) -> Never:
    raise OSError(number, what)
