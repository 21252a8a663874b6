"""The relay and a serial port on USB, through the kernel's own drivers and libusb."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.kernel
Stories = dict[str, list[dict[str, Any]]]


@pytest.fixture(scope="module")
def usb(guest: Callable[[Path], Stories]) -> Stories:
    return guest(Path(__file__).with_name("usb_guest.py"))


def test_the_relay_is_taken_from_the_kernels_driver_and_switches(usb: Stories) -> None:
    [found] = usb["relay"]
    assert found["held"], "the kernel's own driver never held the board: nothing was tried"
    assert found["closed"]
    assert found["open"]
    assert found["switched"] == [[1, True], [1, False]]


def test_a_relay_that_is_pulled_out_is_absent(usb: Stories) -> None:
    assert usb["relay pulled"][0]["error"] == "DeviceAbsentError"


def test_the_trigger_box_fires_over_a_real_serial_port(usb: Stories) -> None:
    [found] = usb["port"]
    assert found["sequence"] == 1
    assert found["raised"][1] is True


def test_opening_a_port_raises_its_lines_for_a_moment_whatever_is_asked(usb: Stories) -> None:
    """The hazard that the commissioning list names: no actuator may hang on a bare modem line."""
    [found] = usb["port"]
    assert [True, True] in found["opened"]
    assert found["opened"][-1] == [False, False]


def test_a_cable_pulled_while_armed_fires_nothing_and_has_its_name(usb: Stories) -> None:
    [found] = usb["port pulled"]
    assert found["error"] in {"DeviceAbsentError", "DeviceAnswerError", "FireOutcomeUnknownError"}
    assert found["fires"] == 1
