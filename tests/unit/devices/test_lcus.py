"""LCUS boards: the published bytes, the fail-safe levels, and one fire at most."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigctl.devices.lcus import COMMAND_S, Holders, LcusRelay, command
from rigctl.devices.serial_port import SerialPort
from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceSilentError,
    FireOutcomeUnknownError,
    SettingsError,
)

MakeDevice = Callable[..., Any]
ON_1, OFF_1 = bytes.fromhex("A00101A2"), bytes.fromhex("A00100A1")
ON_2, OFF_2 = bytes.fromhex("A00201A3"), bytes.fromhex("A00200A2")


class FakeTime:
    """A clock that moves only by waiting."""

    def __init__(self) -> None:
        self.now = 100.0
        self.waits: list[float] = []

    def clock(self) -> float:
        return self.now

    def wait(self, seconds: float) -> None:
        self.waits.append(seconds)
        self.now += seconds


class FailingPort:
    """A port whose nth write fails."""

    part = "solenoids"

    def __init__(self, fails_at: int) -> None:
        self.fails_at, self.sent = fails_at, list[bytes]()

    def held(self) -> nullcontext[None]:
        return nullcontext()

    def discard_stale(self) -> bytes:
        return b""

    def send(self, data: bytes) -> None:
        self.sent.append(data)
        if len(self.sent) == self.fails_at:
            raise DeviceSilentError("stuck", part=self.part)


def opened(path: str) -> SerialPort:
    return SerialPort(path, part="relay", baud=9600, answer_timeout_s=0.1)


def pair(
    port: SerialPort | FailingPort,
    energised: Literal["hold", "release"],
    time: FakeTime | None = None,
) -> Holders:
    time = time or FakeTime()
    return Holders(
        port, channel_a=1, channel_b=2, energised=energised, clock=time.clock, wait=time.wait
    )


def test_the_bytes_are_those_the_vendors_publish() -> None:
    assert (command(1, True), command(1, False)) == (ON_1, OFF_1)


@given(st.integers(0, 255), st.booleans())
def test_a_command_has_four_bytes_and_ends_with_their_sum(channel: int, on: bool) -> None:
    data = command(channel, on)
    assert len(data) == 4
    assert (data[0] + data[1] + data[2] - data[3]) % 256 == 0


def test_cutting_switches_off_and_restoring_switches_on(pty_device: MakeDevice) -> None:
    device = pty_device(length=4)
    relay = LcusRelay(opened(device.path), channel=1)
    relay.check()
    relay.restore()
    relay.cut()
    relay.cut()
    assert device.wait_for(3) == [ON_1, OFF_1, OFF_1]
    relay.close()


def test_only_cutting_opens_a_lost_port_by_itself(pty_device: MakeDevice, tmp_path: Path) -> None:
    first, second = pty_device(length=4), pty_device(length=4)
    link = tmp_path / "board"
    link.symlink_to(first.path)
    relay = LcusRelay(opened(str(link)), channel=1)
    first.hang_up()
    link.unlink()
    link.symlink_to(second.path)
    for act in (relay.check, relay.restore):
        with pytest.raises(DeviceAbsentError):
            act()
    relay.cut()
    assert second.wait_for(1) == [OFF_1]
    relay.restore()
    assert second.wait_for(2) == [OFF_1, ON_1]
    relay.close()


def test_a_solenoid_pair_that_came_back_is_ready_for_no_fire(
    pty_device: MakeDevice, tmp_path: Path
) -> None:
    first, second = pty_device(length=8), pty_device(length=8)
    link = tmp_path / "board"
    link.symlink_to(first.path)
    solenoids = pair(opened(str(link)), "release")
    solenoids.arm(3, 0.0)
    first.hang_up()
    link.unlink()
    link.symlink_to(second.path)
    solenoids.reopen()
    with pytest.raises(DeviceAnswerError, match="no fire command was sent"):
        solenoids.fire(3)
    assert second.messages == []
    solenoids.close()


def test_a_board_that_was_unplugged_is_absent(pty_device: MakeDevice) -> None:
    device = pty_device(length=4)
    relay = LcusRelay(opened(device.path), channel=1)
    device.hang_up()
    with pytest.raises(DeviceAbsentError):
        relay.check()


@pytest.mark.parametrize(
    ("energised", "safe", "fired"),
    [("hold", ON_1 + ON_2, OFF_1 + OFF_2), ("release", OFF_1 + OFF_2, ON_1 + ON_2)],
)
def test_each_polarity_has_its_own_safe_level_and_fires_both_in_one_write(
    pty_device: MakeDevice, energised: str, safe: bytes, fired: bytes
) -> None:
    device = pty_device(length=8)
    solenoids = pair(opened(device.path), energised)
    solenoids.arm(3, 0.0)
    receipt = solenoids.fire(3)
    solenoids.make_safe()
    assert device.wait_for(3) == [safe, fired, safe]
    assert (receipt.sequence, receipt.device_time_us) == (3, None)
    solenoids.close()


@pytest.mark.parametrize(("delay_us", "order"), [(7000, [ON_1, ON_2]), (-7000, [ON_2, ON_1])])
def test_a_delayed_fire_is_timed_by_the_host_in_the_order_of_its_sign(
    delay_us: float, order: list[bytes]
) -> None:
    port, time = FailingPort(fails_at=0), FakeTime()
    solenoids = pair(port, "release", time)
    solenoids.arm(3, delay_us)
    solenoids.fire(3)
    assert port.sent[1:] == order
    assert time.waits == [pytest.approx(0.007)]


@pytest.mark.parametrize("delay_us", [1.0, -4000.0])
def test_a_delay_shorter_than_a_command_on_the_wire_is_refused(delay_us: float) -> None:
    port = FailingPort(fails_at=0)
    with pytest.raises(SettingsError, match="4167 us"):
        pair(port, "hold").arm(3, delay_us)
    assert port.sent == []
    assert pytest.approx(4 * 10 / 9600) == COMMAND_S


@pytest.mark.parametrize("fails_at", [2, 3])
def test_a_port_that_fails_while_firing_leaves_a_doubt_and_is_not_written_again(
    fails_at: int,
) -> None:
    port = FailingPort(fails_at)
    solenoids = pair(port, "release")
    solenoids.arm(3, 5000.0)
    with pytest.raises(FireOutcomeUnknownError, match="none, one or both"):
        solenoids.fire(3)
    with pytest.raises(DeviceAnswerError, match="no fire command"):
        solenoids.fire(3)
    assert len(port.sent) == fails_at


def test_nothing_fires_under_another_number_or_after_make_safe() -> None:
    port = FailingPort(fails_at=0)
    solenoids = pair(port, "hold")
    solenoids.arm(3, 0.0)
    with pytest.raises(DeviceAnswerError):
        solenoids.fire(4)
    solenoids.make_safe()
    with pytest.raises(DeviceAnswerError):
        solenoids.fire(3)
    assert OFF_1 + OFF_2 not in port.sent
