"""A contact on RTS, over pyserial's loop that mirrors RTS to CTS."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rigctl.devices.serial_line import SerialLine
from rigctl.devices.serial_port import SerialPort
from rigctl.errors import DeviceAbsentError, DeviceError

MakeDevice = Callable[..., Any]


def opened(url: str) -> SerialPort:
    return SerialPort(url, part="remote trigger", baud=9600, answer_timeout_s=0.1)


def test_the_contact_starts_open_closes_and_opens() -> None:
    port = opened("loop://")
    line = SerialLine(port)
    line.check()
    assert not port._serial.cts
    line.close_contact()
    assert port._serial.cts
    line.open_contact()
    assert not port._serial.cts
    line.close()


def test_a_port_without_modem_lines_says_so(pty_device: MakeDevice) -> None:
    line = SerialLine(opened(pty_device().path))
    with pytest.raises(DeviceError, match="no RTS line"):
        line.close_contact()
    line.close()


def test_a_port_that_was_unplugged_is_absent(pty_device: MakeDevice) -> None:
    device = pty_device()
    line = SerialLine(opened(device.path))
    device.hang_up()
    with pytest.raises(DeviceAbsentError):
        line.check()
