"""The emergency stop cuts first, on a line of its own, and stays until a person ends it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Never

import pytest
from rig_fakes import BOUND_S, Blocked, Laboratory, in_thread, until

from rigctl.errors import (
    ArmTokenError,
    DeviceError,
    DeviceSilentError,
    InterlockError,
    RefusedError,
)
from rigctl.rig.standing import AFTER_STOP
from rigctl.rig.stopping import estop, latch
from rigctl.store import ShotRecord


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data", threads=True)
    yield laboratory
    laboratory.close()


def notes(lab: Laboratory) -> str:
    entries = lab.store.journal.entries(limit=1000)
    return "\n".join(entry.reason for entry in entries if entry.actor == AFTER_STOP)


def fire_in_background(lab: Laboratory) -> ShotRecord:
    return lab.rig.accept(lab.arm(), "mine", "body", actor="anna")


def test_a_stop_cuts_latches_and_disarms(lab: Laboratory) -> None:
    token = lab.arm()
    lab.rig.estop("berta", "smoke")
    assert lab.cut_off.power is False
    assert lab.state == "estop"
    assert lab.rig.status().latch_reason == "smoke"
    with pytest.raises(ArmTokenError, match="emergency stop"):
        lab.fire(token)
    with pytest.raises(RefusedError, match="estop"):
        lab.arm()


def test_the_cut_does_not_wait_for_a_fire_command_that_blocks(lab: Laboratory) -> None:
    blocked = Blocked(lab.trigger, "fire")
    shot = fire_in_background(lab)
    assert blocked.reached.wait(BOUND_S)
    lab.cut_off.was_cut.clear()
    lab.rig.estop("berta", "a hand in the tube")
    assert lab.cut_off.was_cut.is_set()
    assert not blocked.go_on.is_set()
    assert lab.state == "estop"
    assert lab.store.shot(shot.id).state == "unknown_outcome"
    blocked.go_on.set()
    ended = lab.rig.wait(shot.id, BOUND_S)
    assert (ended.outcome, ended.fired) == ("unknown_outcome", "unknown")
    assert "capture.collect" not in lab.log
    assert lab.state == "estop"


def test_the_cut_does_not_wait_for_the_rigs_lock(lab: Laboratory) -> None:
    lab.cut_off.was_cut.clear()
    with lab.rig._standing.lock:
        thread = in_thread(lambda: lab.rig.estop("berta", "smoke"))
        assert lab.cut_off.was_cut.wait(BOUND_S)
        assert thread.is_alive()
    thread.join(BOUND_S)
    assert lab.state == "estop"


def test_a_stop_while_the_frames_come_still_stores_the_shot(lab: Laboratory) -> None:
    blocked = Blocked(lab.capture, "collect")
    shot = fire_in_background(lab)
    assert blocked.reached.wait(BOUND_S)
    lab.rig.estop("berta", "smoke")
    with pytest.raises(RefusedError, match="under way"):
        lab.rig.release("berta", "too early")
    blocked.go_on.set()
    assert lab.rig.wait(shot.id, BOUND_S).outcome == "stored"
    assert lab.state == "estop"


def test_a_stop_before_the_fire_command_leaves_it_unsent(lab: Laboratory) -> None:
    blocked = Blocked(lab.trigger, "arm")
    states: list[str] = []
    lab.store.listeners.add(lambda record: states.append(str(record.state)))
    shot = fire_in_background(lab)
    assert blocked.reached.wait(BOUND_S)
    lab.rig.estop("berta", "smoke")
    blocked.go_on.set()
    ended = lab.rig.wait(shot.id, BOUND_S)
    assert (states, ended.fired) == (["accepted", "aborted"], "no")
    assert lab.trigger.fired == []


def test_a_fire_confirmed_after_the_stop_but_before_the_rig_followed_is_unknown(
    lab: Laboratory,
) -> None:
    firing, cutting = Blocked(lab.trigger, "fire"), Blocked(lab.cut_off, "cut")
    shot = fire_in_background(lab)
    assert firing.reached.wait(BOUND_S)
    stopping = in_thread(lambda: lab.rig.estop("berta", "smoke"))
    assert cutting.reached.wait(BOUND_S)
    until(lambda: lab.rig._stop.latch is not None)
    firing.go_on.set()
    ended = lab.rig.wait(shot.id, BOUND_S)
    assert (ended.outcome, ended.fired) == ("unknown_outcome", "unknown")
    cutting.go_on.set()
    stopping.join(BOUND_S)
    assert lab.state == "estop"


def test_a_stop_between_intent_and_fire_command_leaves_it_unsent(lab: Laboratory) -> None:
    done = []

    def stop_once(shot: ShotRecord) -> None:
        if shot.state == "firing" and not done:
            done.append(in_thread(lambda: lab.rig.estop("berta", "smoke")))
            assert lab.cut_off.was_cut.wait(BOUND_S)
            until(lambda: lab.rig._stop.latch is not None)

    lab.cut_off.was_cut.clear()
    lab.store.listeners.add(stop_once)
    shot = fire_in_background(lab)
    ended = lab.rig.wait(shot.id, BOUND_S)
    done[0].join(BOUND_S)
    assert lab.trigger.fired == []
    assert ended.outcome in {"aborted", "unknown_outcome"}
    assert lab.state == "estop"


def test_a_stop_ends_the_wait_for_pressure(lab: Laboratory) -> None:
    lab.regulator.lag_s = 1e9
    stopped = []

    def stop_once() -> None:
        if not stopped:
            stopped.append(True)
            lab.rig.estop("berta", "smoke")

    lab.regulator.hooks["pressure"] = stop_once
    began = lab.time.now
    with pytest.raises(InterlockError, match="latch: stopped by berta: smoke"):
        lab.arm()
    assert lab.time.now - began < 1.0
    assert lab.state == "estop"


def test_the_trigger_is_made_safe_afterwards_by_somebody_who_is_not_waited_for(
    lab: Laboratory,
) -> None:
    lab.log.clear()
    blocked = Blocked(lab.trigger, "make_safe")
    lab.rig.estop("berta", "smoke")
    assert lab.log[0] == "cut_off.cut"
    assert blocked.reached.wait(BOUND_S)
    blocked.go_on.set()


def test_a_cut_that_fails_is_tried_again(lab: Laboratory) -> None:
    lab.cut_off.errors["cut"] = DeviceSilentError("no line")
    with pytest.raises(DeviceError, match=r"could not be cut: no line; switch .* off by hand"):
        lab.rig.estop("berta", "smoke")
    assert lab.log.count("cut_off.cut") == estop.CUT_ATTEMPTS
    assert lab.state == "estop"
    assert lab.rig.status().latch_reason == "smoke"


def test_a_cut_that_succeeds_at_last_is_a_stop_like_any_other(lab: Laboratory) -> None:
    failing = iter([DeviceSilentError("no line"), DeviceSilentError("no line")])

    def fail_twice() -> None:
        for error in failing:
            raise error

    lab.cut_off.hooks["cut"] = fail_twice
    lab.rig.estop("berta", "smoke")
    assert (lab.cut_off.power, lab.rig.status().warnings) == (False, ())


def test_a_cut_that_failed_is_warned_of_and_journalled_until_one_is_confirmed(
    lab: Laboratory,
) -> None:
    lab.cut_off.errors["cut"] = DeviceSilentError("no line")
    with pytest.raises(DeviceError):
        lab.rig.estop("berta", "smoke")
    until(lambda: "still reports power" in lab.rig.status().warnings[0])
    (warning,) = lab.rig.status().warnings
    assert "NOT confirmed off: the cut failed (no line)" in warning
    assert "off by hand" in warning
    assert "NOT confirmed off" in notes(lab)
    lab.cut_off.errors.clear()
    lab.rig.estop("berta", "again")
    assert lab.rig.status().warnings == ()


def test_power_that_is_gone_without_the_cut_needs_no_warning(lab: Laboratory) -> None:
    lab.cut_off.errors["cut"] = DeviceSilentError("no line")
    lab.trigger.has_power = False
    with pytest.raises(DeviceError):
        lab.rig.estop("berta", "the plug was pulled")
    until(lambda: lab.rig.status().warnings == ())


def test_a_trigger_that_cannot_say_leaves_a_warning_and_no_failure(lab: Laboratory) -> None:
    lab.trigger.errors["powered"] = DeviceSilentError("no answer")
    lab.rig.estop("berta", "smoke")
    assert "cannot say whether its outputs have power" in lab.rig.status().warnings[0]


def test_a_trigger_that_hangs_holds_the_stop_no_longer_than_its_bound(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estop, "WITNESS_WAIT_S", 0.05)
    blocked = Blocked(lab.trigger, "powered")
    lab.rig.estop("berta", "smoke")
    assert (lab.state, lab.cut_off.power) == ("estop", False)
    assert "not yet said" in lab.rig.status().warnings[0]
    blocked.go_on.set()
    until(lambda: lab.rig.status().warnings == ())


def test_after_the_cut_slide_regulators_and_trigger_are_brought_to_rest_and_journalled(
    lab: Laboratory,
) -> None:
    lab.arm()
    lab.log.clear()
    lab.slide.errors["stop"] = DeviceSilentError("no line")
    lab.rig.estop("berta", "smoke")
    until(lambda: "trigger (stand-in): safe" in notes(lab))
    assert lab.log.index("cut_off.cut") < lab.log.index("slide.stop")
    assert "slide (stand-in): NOT stopped (no line)" in notes(lab)
    assert "regulator (stand-in): set to 0 kPa" in notes(lab)
    assert lab.rig.status().latch_reason == "smoke"


def test_a_set_point_that_leaves_after_the_stop_has_halted_is_taken_back(lab: Laboratory) -> None:
    def stop_and_halt() -> None:
        lab.slide.hooks.clear()
        lab.rig.estop("berta", "smoke")
        until(lambda: "trigger (stand-in): safe" in notes(lab))
        lab.log.clear()

    lab.slide.hooks["move_to"] = stop_and_halt
    with pytest.raises(InterlockError, match="latch"):
        lab.arm()
    assert [call for call in lab.log if call in {"slide.stop", "regulator.vent"}] == [
        "slide.stop",
        "regulator.vent",
    ]


def test_nothing_is_released_while_the_stop_still_brings_devices_to_rest(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estop, "REST_WAIT_S", 0.05)
    blocked = Blocked(lab.slide, "stop")
    lab.rig.estop("berta", "smoke")
    assert blocked.reached.wait(BOUND_S)
    with pytest.raises(RefusedError, match="still bringing the devices to rest"):
        lab.rig.release("berta", "too early")
    assert (lab.state, lab.cut_off.power) == ("estop", False)
    blocked.go_on.set()
    until(lambda: "trigger (stand-in): safe" in notes(lab))
    monkeypatch.setattr(estop, "REST_WAIT_S", BOUND_S)
    lab.rig.release("berta", "only steam")
    assert lab.state == "idle"


def test_a_restore_that_fails_takes_the_power_again(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    lab.rig.estop("berta", "smoke")

    def cannot_forget(_file: latch.LatchFile) -> Never:
        raise RefusedError("the latch file cannot be removed")

    monkeypatch.setattr(latch.LatchFile, "forget", cannot_forget)
    with pytest.raises(RefusedError, match="cannot be removed"):
        lab.rig.release("berta", "only steam")
    assert (lab.state, lab.cut_off.power) == ("estop", False)


def test_a_cut_off_that_hangs_lets_the_caller_go_and_latches(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estop, "LINE_WAIT_S", 0.05)
    blocked = Blocked(lab.cut_off, "cut")
    with pytest.raises(DeviceSilentError, match="could not be cut"):
        lab.rig.estop("berta", "smoke")
    assert lab.state == "estop"
    blocked.go_on.set()
    assert lab.cut_off.was_cut.wait(BOUND_S)
