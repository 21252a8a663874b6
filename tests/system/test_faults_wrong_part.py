"""What is not what it should be: named, safe and recorded; the next shot works without a restart.

Cables pulled, late answers and a clock that jumps strike in every state of a shot by the plan of
`benchmarks.faults`; a tape at its end stands with the keypad, a camera of another size with the
camera that has a memory of its own.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rigctl.daemon import Daemon, open_daemon
from rigctl.errors import RigError
from rigctl.settings import ShotSettings
from rigctl.store import ShotRecord
from tests.simulated import with_short_films

SETTINGS = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)
NAMED = {
    "trigger": "trigger",
    "regulator": "regulator",
    "slide": "slide",
    "recorder": "camera",
}
"""What the refusal must name, by the port on which another device sits."""


@pytest.fixture
def daemon(tmp_path: Path) -> Iterator[Daemon]:
    with open_daemon(with_short_films(tmp_path / "data")) as opened:
        yield opened


@pytest.fixture
def laboratory(daemon: Daemon) -> Any:
    return daemon.laboratory


def arm(daemon: Daemon) -> str:
    return daemon.rig.arm(SETTINGS, "anna").token


def fire(daemon: Daemon, token: str) -> ShotRecord:
    return daemon.rig.fire(token, token, "body", actor="anna")


def require_next_shot(daemon: Daemon, laboratory: Any, fires: int) -> None:
    laboratory.clear_faults()
    if daemon.rig.status().latch_reason is not None:
        daemon.rig.release("anna", "the right device is back")
    assert fire(daemon, arm(daemon)).outcome == "stored"
    assert laboratory.fires == fires + 1


@pytest.mark.parametrize("role", NAMED)
def test_another_device_on_the_port_is_named_when_the_rig_is_armed(
    daemon: Daemon, laboratory: Any, role: str
) -> None:
    laboratory.fault(role, "wrong-device")
    with pytest.raises(RigError) as refused:
        arm(daemon)
    assert NAMED[role] in str(refused.value)
    assert laboratory.fires == 0
    require_next_shot(daemon, laboratory, 0)


@pytest.mark.parametrize("role", NAMED)
def test_another_device_that_came_while_armed_fires_nothing_and_the_shot_says_why(
    daemon: Daemon, laboratory: Any, role: str
) -> None:
    token = arm(daemon)
    laboratory.fault(role, "wrong-device")
    shot = fire(daemon, token)
    assert (shot.outcome, shot.fired, laboratory.fires) == ("aborted", "no", 0)
    assert shot.failure is not None
    assert NAMED[role] in shot.failure or role in shot.failure
    require_next_shot(daemon, laboratory, 0)


def test_a_stranger_in_the_place_of_the_cut_off_is_seen_by_the_trigger_at_a_stop(
    daemon: Daemon, laboratory: Any
) -> None:
    laboratory.fault("cut-off", "wrong-device")
    with pytest.raises(RigError, match="NOT off after the cut"):
        daemon.rig.estop("anna", "smoke")
    assert "NOT confirmed off" in daemon.rig.status().warnings[0]
    laboratory.clear_faults()
    daemon.rig.estop("anna", "again")
    assert laboratory.state()["powered"] is False
    require_next_shot(daemon, laboratory, 0)


def test_firmware_of_a_version_that_nobody_knows_is_named_with_its_version(
    daemon: Daemon, laboratory: Any, caplog: pytest.LogCaptureFixture
) -> None:
    laboratory.fault("trigger", "other-firmware")
    with caplog.at_level(logging.WARNING), pytest.raises(RigError) as refused:
        arm(daemon)
    assert "trigger" in str(refused.value)
    assert "RIGTRIG 3 2" in str(refused.value)
    assert "RIGTRIG 3 2" in caplog.text
    require_next_shot(daemon, laboratory, 0)


def test_firmware_that_was_flashed_while_armed_fires_nothing(
    daemon: Daemon, laboratory: Any
) -> None:
    token = arm(daemon)
    laboratory.fault("trigger", "other-firmware")
    shot = fire(daemon, token)
    assert (shot.outcome, shot.fired, laboratory.fires) == ("aborted", "no", 0)
    assert "RIGTRIG 3 2" in (shot.failure or "")
    require_next_shot(daemon, laboratory, 0)
