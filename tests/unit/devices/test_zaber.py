"""The slide over the vendor's library against a stage of a few lines, behind a pseudo-terminal."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import serial

from rigctl.devices.zaber import ZaberSlide
from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceBusyError,
    DeviceSilentError,
)

MakeDevice = Callable[..., Any]
STEPS = 1000.0


class Stage:
    """Answers in Zaber's ASCII protocol; a move ends at once, homing when told."""

    def __init__(self, referenced: bool = True) -> None:
        self.commands: list[str] = []
        self.position, self.referenced = 0, referenced
        self.busy_polls, self.silent, self.rejects = 0, False, False

    def __call__(self, message: bytes) -> bytes:
        words = message.decode().strip("/\n\r").partition(":")[0].split()
        numbers = [word for word in words if word.isdigit()][:3]
        command = " ".join(words[len(numbers) :])
        self.commands.append(command)
        if self.silent:
            return b""
        verdict, data = self._obey(command)
        status = "BUSY" if self.busy_polls > 0 else "IDLE"
        self.busy_polls -= not command
        axis, identity = [*numbers, "0", "0"][1], [*numbers, "", "", ""][2]
        warning = "--" if self.referenced else "WR"
        return f"@01 {axis} {identity} {verdict} {status} {warning} {data}\r\n".encode()

    def _obey(self, command: str) -> tuple[str, str]:
        if command.startswith("move abs"):
            if self.rejects:
                return "RJ", "BADDATA"
            self.position = int(command.removeprefix("move abs "))
        if command == "home":
            self.position, self.referenced = 0, True
        known = {
            "get pos": str(self.position),
            "get comm.packet.size.max": "80",
            "warnings": "00" if self.referenced else "01 WR",
        }
        return "OK", known.get(command, "0")


def slide(path: str, **options: Callable[..., Any]) -> ZaberSlide:
    return ZaberSlide(path, microsteps_per_mm=STEPS, answer_timeout_s=0.2, **options)


def test_a_move_is_in_native_microsteps_and_the_position_in_mm(pty_device: MakeDevice) -> None:
    stage = Stage()
    moved = slide(pty_device(stage).path, clock=lambda: 5.0)
    moved.move_to(6.0)
    assert "move abs 6000" in stage.commands
    reading = moved.position()
    assert (reading.value, reading.unit, reading.read_at) == (6.0, "mm", 5.0)
    assert not moved.is_moving()
    assert not [word for word in stage.commands if "deviceid" in word]
    moved.close()


def test_a_stage_without_reference_has_no_position_and_homes_before_its_first_move(
    pty_device: MakeDevice,
) -> None:
    stage = Stage(referenced=False)
    waits: list[float] = []
    moved = slide(pty_device(stage).path, wait=waits.append)
    with pytest.raises(DeviceAnswerError, match="does not know where it is"):
        moved.position()
    stage.busy_polls = 3
    moved.move_to(1.0)
    assert stage.commands.index("home") < stage.commands.index("move abs 1000")
    assert len(waits) == 3
    moved.close()


def test_a_home_sensor_that_is_never_found_stops_the_stage_within_the_bound(
    pty_device: MakeDevice,
) -> None:
    stage = Stage(referenced=False)
    now = iter(range(0, 1000, 10))
    moved = slide(pty_device(stage).path, clock=lambda: float(next(now)), wait=lambda s: None)
    stage.busy_polls = 10**6
    with pytest.raises(DeviceSilentError, match="30 s"):
        moved.move_to(1.0)
    assert stage.commands[-1] == "stop"
    assert "move abs 1000" not in stage.commands
    moved.close()


def test_a_move_is_stopped_without_waiting_for_the_rest(pty_device: MakeDevice) -> None:
    stage = Stage()
    moved = slide(pty_device(stage).path)
    stage.busy_polls = 10**6
    moved.move_to(6.0)
    moved.stop()
    assert stage.commands[-1] == "stop"
    moved.close()


def test_a_refused_move_is_an_answer_error(pty_device: MakeDevice) -> None:
    stage = Stage()
    stage.rejects = True
    moved = slide(pty_device(stage).path)
    with pytest.raises(DeviceAnswerError, match="move to 900 mm"):
        moved.move_to(900.0)
    moved.close()


def test_a_silent_stage_is_named_with_the_bound(pty_device: MakeDevice) -> None:
    stage = Stage()
    moved = slide(pty_device(stage).path)
    stage.silent = True
    with pytest.raises(DeviceSilentError, match=r"0\.2 s"):
        moved.check()
    moved.close()


def test_a_port_that_another_program_holds_is_busy(pty_device: MakeDevice) -> None:
    device = pty_device(Stage())
    other = serial.Serial(device.path, exclusive=True)
    with pytest.raises(DeviceBusyError):
        slide(device.path)
    other.close()


def test_a_port_that_does_not_exist_is_absent(tmp_path: Path) -> None:
    with pytest.raises(DeviceAbsentError):
        slide(str(tmp_path / "nothing"))


def test_a_connection_that_was_closed_is_absent_and_reopening_brings_it_back(
    pty_device: MakeDevice,
) -> None:
    moved = slide(pty_device(Stage()).path)
    moved.close()
    with pytest.raises(DeviceAbsentError):
        moved.position()
    with pytest.raises(DeviceAbsentError):
        moved.check()
    moved.reopen()
    assert moved.position().value == 0.0
    moved.close()
    moved.close()
