"""Lines that are lost and come back: each is named, and works again once it is plugged in."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rigctl.daemon import Daemon, open_daemon
from rigctl.errors import DeviceError, InterlockError, RigError
from rigctl.settings import ShotSettings
from rigctl.store import ShotRecord
from tests.simulated import with_short_films

SETTINGS = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)
FAR = ShotSettings(pressure_a_kpa=110.0, pressure_b_kpa=110.0, offset_mm=23.0)
ALIKE = [pytest.param(role, marks=pytest.mark.long) for role in ("regulator", "slide", "recorder")]
LINES = ["cut-off", "trigger", *ALIKE]
MOVING = ["trigger", "regulator", "slide"]


@pytest.fixture
def daemon(tmp_path: Path) -> Iterator[Daemon]:
    configuration = with_short_films(tmp_path / "data")
    assert configuration.simulation is not None
    slow = configuration.simulation.model_copy(update={"slide_speed_mm_per_s": 20.0})
    with open_daemon(configuration.model_copy(update={"simulation": slow})) as opened:
        yield opened


@pytest.fixture
def laboratory(daemon: Daemon) -> Any:
    return daemon.laboratory


def until(condition: Callable[[], bool]) -> None:
    """Return once the condition holds; fail after five seconds."""
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.002)


def arm(daemon: Daemon) -> str:
    return daemon.rig.arm(SETTINGS, "anna").token


def fire(daemon: Daemon, token: str) -> ShotRecord:
    return daemon.rig.fire(token, token, "body", actor="anna")


def release_if_latched(daemon: Daemon) -> None:
    if daemon.rig.status().latch_reason is not None:
        daemon.rig.release("anna", "plugged in again")


def notes(daemon: Daemon) -> str:
    return "\n".join(entry.reason for entry in daemon.store.journal.entries(limit=1000))


@pytest.mark.parametrize("role", LINES)
def test_a_line_lost_before_arming_refuses_and_fires_again_once_it_is_back(
    daemon: Daemon, laboratory: Any, role: str
) -> None:
    laboratory.fault(role, "unplug")
    with pytest.raises(RigError):
        arm(daemon)
    laboratory.fault(role, "plug-in")
    release_if_latched(daemon)
    shot = fire(daemon, arm(daemon))
    assert (shot.outcome, laboratory.fires) == ("stored", 1)


@pytest.mark.parametrize("role", LINES)
def test_a_line_lost_and_back_while_nobody_looked_arms_at_once(
    daemon: Daemon, laboratory: Any, role: str
) -> None:
    laboratory.fault(role, "unplug")
    laboratory.fault(role, "plug-in")
    shot = fire(daemon, arm(daemon))
    assert (shot.outcome, laboratory.fires) == ("stored", 1)


@pytest.mark.parametrize("back", [True, False], ids=["plugged in", "still away"])
@pytest.mark.parametrize("role", LINES)
def test_a_line_lost_while_armed_fires_nothing_until_the_rig_is_armed_again(
    daemon: Daemon, laboratory: Any, role: str, back: bool
) -> None:
    token = arm(daemon)
    laboratory.fault(role, "unplug")
    if back:
        laboratory.fault(role, "plug-in")
    shot = fire(daemon, token)
    assert (shot.outcome, shot.fired, laboratory.fires) == ("aborted", "no", 0)
    laboratory.fault(role, "plug-in")
    release_if_latched(daemon)
    assert fire(daemon, arm(daemon)).outcome == "stored"
    assert laboratory.fires == 1


def test_a_remote_trigger_that_was_pulled_while_armed_comes_back(
    daemon: Daemon, laboratory: Any
) -> None:
    token = arm(daemon)
    laboratory.fault("relay", "disconnect")
    assert fire(daemon, token).outcome == "aborted"
    laboratory.clear_faults()
    release_if_latched(daemon)
    assert fire(daemon, arm(daemon)).outcome == "stored"


def test_nothing_moves_while_the_line_of_the_stop_is_dead(daemon: Daemon, laboratory: Any) -> None:
    laboratory.fault("cut-off", "unplug")
    before = laboratory.state()
    with pytest.raises(InterlockError) as caught:
        daemon.rig.arm(FAR, "anna")
    assert any(sentence.startswith("cut_off:") for sentence in caught.value.tripped)
    assert laboratory.state() == before


def test_a_stop_on_a_dead_line_warns_until_a_later_stop_reaches_the_board(
    daemon: Daemon, laboratory: Any
) -> None:
    arm(daemon)
    laboratory.fault("cut-off", "unplug")
    with pytest.raises(DeviceError, match=r"could not be cut.*by hand"):
        daemon.rig.estop("berta", "smoke")
    assert laboratory.state()["powered"] is True
    (warning,) = daemon.rig.status().warnings
    assert "NOT confirmed off" in warning
    assert "NOT confirmed off" in notes(daemon)
    laboratory.fault("cut-off", "plug-in")
    daemon.rig.estop("berta", "again")
    assert laboratory.state()["powered"] is False
    assert daemon.rig.status().warnings == ()
    daemon.rig.release("berta", "only steam")
    assert fire(daemon, arm(daemon)).outcome == "stored"


def test_a_cut_off_that_came_back_unnoticed_is_cut_by_the_first_stop(
    daemon: Daemon, laboratory: Any
) -> None:
    laboratory.fault("cut-off", "unplug")
    laboratory.fault("cut-off", "plug-in")
    daemon.rig.estop("berta", "smoke")
    assert laboratory.state()["powered"] is False


def test_a_relay_that_sticks_is_seen_by_the_trigger_and_told(
    daemon: Daemon, laboratory: Any
) -> None:
    laboratory.fault("cut-off", "stuck")
    with pytest.raises(DeviceError, match=r"NOT off after the cut.*still reports power"):
        daemon.rig.estop("berta", "smoke")
    assert daemon.rig.status().state == "estop"
    assert "still reports power" in daemon.rig.status().warnings[0]


def test_a_cut_that_the_trigger_cannot_witness_is_made_and_warned_of(
    daemon: Daemon, laboratory: Any
) -> None:
    laboratory.fault("trigger", "unplug")
    daemon.rig.estop("berta", "smoke")
    until(lambda: laboratory.state()["powered"] is False)
    assert "cannot say" in daemon.rig.status().warnings[0]


@pytest.mark.parametrize("role", MOVING)
def test_a_stop_is_made_whatever_else_is_unplugged(
    daemon: Daemon, laboratory: Any, role: str
) -> None:
    laboratory.fault(role, "unplug")
    daemon.rig.estop("berta", "smoke")
    until(lambda: laboratory.state()["powered"] is False)
    until(lambda: "NOT" in notes(daemon))
    laboratory.fault(role, "plug-in")
    daemon.rig.release("berta", "plugged in")
    assert fire(daemon, arm(daemon)).outcome == "stored"
