"""A killed daemon fires nothing again, loses nothing acknowledged, and says what is open."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from rig_fakes import BOUND_S, Laboratory

from rigctl.errors import DeviceSilentError, RefusedError
from rigctl.rig.recovery import Recovery, start_state
from rigctl.rig.states import RigState

DAEMON = Path(__file__).with_name("killed_daemon.py")

# Where the kill falls; fires before it; the shot and the rig after the restart.
POINTS = [
    ("row accepted", 0, "interrupted", "no", "estop"),
    ("start", 0, "interrupted", "no", "estop"),
    ("trigger armed", 0, "interrupted", "no", "estop"),
    ("row firing", 0, "unknown_outcome", "unknown", "unknown_outcome"),
    ("before the byte", 0, "unknown_outcome", "unknown", "unknown_outcome"),
    ("after the byte", 1, "unknown_outcome", "unknown", "unknown_outcome"),
    ("row capturing", 1, "interrupted", "yes", "estop"),
    ("mark", 1, "unknown_outcome", "unknown", "unknown_outcome"),
    ("collect", 1, "interrupted", "yes", "estop"),
    ("folder whole, row to come", 1, "stored", "yes", "estop"),
    ("row stored", 1, "stored", "yes", "estop"),
    ("stop", 1, "stored", "yes", "estop"),
]


def fires(folder: Path) -> int:
    counter = folder / "fires"
    return len(counter.read_text().splitlines()) if counter.exists() else 0


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of daemons that were killed, each in a folder with its point's number."""
    folder = tmp_path_factory.mktemp("killed")
    done = subprocess.run(
        [sys.executable, str(DAEMON), str(folder), *(case[0] for case in POINTS)],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    assert done.stdout.split() == [str(int(signal.SIGKILL))] * len(POINTS)
    return folder


@pytest.mark.parametrize("number", range(len(POINTS)), ids=[case[0] for case in POINTS])
def test_after_a_kill_the_shot_is_closed_and_never_fired_again(killed: Path, number: int) -> None:
    _, fired, shot_state, flown, rig_state = POINTS[number]
    folder = killed / str(number)
    assert fires(folder) == fired

    lab = Laboratory(folder / "data")
    shot = lab.store.shot("20260131-000001")
    assert (shot.state, shot.outcome, shot.fired) == (shot_state, shot_state, flown)
    assert lab.state == rig_state
    assert lab.rig.fire("any token", "the key", "body", actor="anna").outcome == shot_state
    assert lab.trigger.fired == []
    assert lab.store.folders.is_whole(shot.id) == (shot_state == "stored")
    assert lab.to_analyse == ([shot.id] if shot_state == "stored" else [])
    with pytest.raises(RefusedError, match=rig_state):
        lab.arm()
    lab.rig.release("anna", "looked into the tray")
    assert lab.shoot().number == 2
    lab.store.journal.verify()
    lab.close()


@pytest.mark.parametrize(
    ("last", "unknown", "latched", "clean", "state"),
    [
        ("idle", (), False, True, "idle"),
        ("idle", (), False, False, "estop"),
        ("armed", (), False, False, "estop"),
        ("capturing", (), False, False, "estop"),
        ("fault", (), False, True, "fault"),
        ("fault", (), False, False, "fault"),
        ("unknown_outcome", (), False, True, "unknown_outcome"),
        ("firing", ("20260131-000001",), False, False, "unknown_outcome"),
        ("fault", ("20260131-000001",), False, False, "unknown_outcome"),
        ("estop", ("20260131-000001",), False, True, "estop"),
        ("firing", ("20260131-000001",), True, False, "estop"),
        ("idle", (), True, True, "estop"),
    ],
)
def test_a_restart_ends_nothing_that_a_person_has_to_end(
    last: str, unknown: tuple[str, ...], latched: bool, clean: bool, state: str
) -> None:
    recovery = Recovery((), unknown, (), (), 0)
    assert start_state(RigState(last), recovery, latched=latched, clean=clean) == state


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data")
    yield laboratory
    laboratory.close()


def test_a_first_start_makes_the_trigger_safe_before_it_gives_power(lab: Laboratory) -> None:
    acts = [call for call in lab.log if call not in {"cut_off.reopen", "trigger.powered"}]
    assert acts == ["trigger.make_safe", "cut_off.restore"]
    assert lab.state == "idle"


def test_a_fault_outlives_the_daemon(lab: Laboratory) -> None:
    lab.regulator.errors["set_pressure"] = DeviceSilentError("gave no answer")
    with pytest.raises(DeviceSilentError):
        lab.arm()
    lab.regulator.errors.clear()
    lab.cut_off.power = False
    lab.restart()
    assert lab.state == "fault"
    assert lab.cut_off.power is False
    lab.rig.release("anna", "plugged it in")
    assert lab.cut_off.power is True
    assert lab.shoot().state == "stored"


def test_a_latch_has_the_time_and_reason_at_which_it_began_however_often_the_daemon_starts(
    lab: Laboratory,
) -> None:
    lab.time.pass_time(60.0)
    lab.regulator.errors["set_pressure"] = DeviceSilentError("gave no answer")
    with pytest.raises(DeviceSilentError):
        lab.arm()
    lab.regulator.errors.clear()
    failed_at = lab.time.wall()
    for _ in range(3):
        lab.time.pass_time(600.0)
        lab.start_again()
        status = lab.rig.status()
        assert (status.state, status.since, status.latch_reason) == (
            "fault",
            failed_at,
            "gave no answer",
        )
    lab.rig.release("anna", "plugged it in")
    lab.time.pass_time(60.0)
    lab.rig.estop("berta", "smoke")
    stopped_at = lab.time.wall()
    for _ in range(3):
        lab.time.pass_time(600.0)
        lab.start_again()
        status = lab.rig.status()
        assert (status.state, status.since, status.latch_reason) == ("estop", stopped_at, "smoke")


def test_an_armed_rig_starts_idle_and_its_token_is_dead(lab: Laboratory) -> None:
    token = lab.arm()
    lab.start_again()
    assert lab.state == "idle"
    with pytest.raises(RefusedError, match="not armed"):
        lab.fire(token)


@pytest.mark.parametrize(("part", "call"), [("trigger", "make_safe"), ("cut_off", "restore")])
def test_a_device_that_is_missing_at_the_start_is_a_fault_and_leaves_no_power(
    lab: Laboratory, part: str, call: str, caplog: pytest.LogCaptureFixture
) -> None:
    lab.close()
    error = DeviceSilentError("gave no answer", part=part, todo="look at its port")
    getattr(lab, part).errors[call] = error
    lab.open()
    assert lab.state == "fault"
    assert f"{part}: gave no answer" in caplog.text
    assert "look at its port" in caplog.text
    assert lab.cut_off.power is False
    getattr(lab, part).errors.clear()
    lab.rig.release("anna", "plugged it in")
    assert lab.state == "idle"


def test_a_stop_at_the_start_cuts_even_when_the_trigger_is_missing(lab: Laboratory) -> None:
    lab.rig.estop("berta", "smoke")
    lab.abandon()
    lab.cut_off.power = True
    lab.trigger.errors["make_safe"] = DeviceSilentError("gave no answer")
    lab.open()
    assert (lab.state, lab.cut_off.power) == ("estop", False)
    lab.trigger.errors.clear()


def test_what_was_half_written_is_removed_and_counted(lab: Laboratory) -> None:
    lab.shoot()
    leftover = lab.folder / "shots" / "20260131" / ".20260131-000002.partial"
    leftover.mkdir()
    lab.restart()
    assert lab.recovery.partial_removed == 1
    assert not leftover.exists()


def test_shots_whose_analysis_was_under_way_are_handed_over_again(lab: Laboratory) -> None:
    shot = lab.shoot()
    lab.store.move(shot.id, "analysing")
    lab.to_analyse.clear()
    lab.restart()
    assert lab.to_analyse == [shot.id]
    assert lab.store.shot(shot.id).state == "stored"


def test_the_state_report_knows_the_last_shot_of_the_daemon_before(lab: Laboratory) -> None:
    shot = lab.shoot()
    lab.restart()
    assert lab.rig.status().last_shot == shot


def test_closing_takes_the_power_and_may_be_done_twice(lab: Laboratory) -> None:
    lab.arm()
    lab.rig.close()
    assert lab.state == "idle"
    assert lab.cut_off.power is False
    lab.rig.close()


def test_closing_waits_for_the_shot_under_way(tmp_path: Path) -> None:
    lab = Laboratory(tmp_path / "data", threads=True)
    recording, go_on = threading.Event(), threading.Event()

    def collect() -> None:
        recording.set()
        go_on.wait(BOUND_S)

    lab.capture.hooks["collect"] = collect
    shot = lab.rig.accept(lab.arm(), "mine", "body", actor="anna")
    assert recording.wait(BOUND_S)
    closing = threading.Thread(target=lab.rig.close)
    closing.start()
    go_on.set()
    closing.join(BOUND_S)
    assert lab.store.shot(shot.id).outcome == "stored"
    assert lab.log.index("capture.stop") < lab.log.index("cut_off.cut")
    lab.store.close()
