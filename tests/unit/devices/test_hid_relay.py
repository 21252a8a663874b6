"""The USB relay through pyusb, over a bus of a few lines."""

from __future__ import annotations

import errno
from array import array
from types import SimpleNamespace

import pytest
import usb.backend
import usb.core

from rigctl.devices.hid_relay import HidRelay
from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceBusyError,
    DeviceError,
    DeviceSilentError,
)

SWITCH_ON_2 = ((0x21, 0x09, 0x0300, 0), bytes.fromhex("ff02000000000000"))
SWITCH_OFF_2 = ((0x21, 0x09, 0x0300, 0), bytes.fromhex("fd02000000000000"))


class Bus(usb.backend.IBackend):  # type: ignore[misc]  # pyusb has no types
    """One relay board; `state` is what GET_REPORT tells, `fails` what every transfer raises."""

    def __init__(self) -> None:
        super().__init__()
        self.written: list[tuple[tuple[object, ...], bytes]] = []
        self.state, self.obeys, self.plugged, self.kernel = 0, True, True, True
        self.fails: Exception | None = None
        self.report_bytes = 8

    def enumerate_devices(self) -> list[str]:
        return ["board"] if self.plugged else []

    def get_device_descriptor(self, dev: str) -> SimpleNamespace:
        return SimpleNamespace(
            bLength=18, bDescriptorType=1, bcdUSB=0x110, bDeviceClass=0, bDeviceSubClass=0,
            bDeviceProtocol=0, bMaxPacketSize0=8, idVendor=0x16C0, idProduct=0x05DF,
            bcdDevice=1, iManufacturer=0, iProduct=0, iSerialNumber=0, bNumConfigurations=1,
            address=1, bus=1, port_number=1, port_numbers=(1,), speed=1,
        )  # fmt: skip

    def open_device(self, dev: str) -> str:
        return dev

    def close_device(self, handle: str) -> None:
        pass

    def claim_interface(self, handle: str, interface: int) -> None:
        pass

    def release_interface(self, handle: str, interface: int) -> None:
        if self.fails is not None:
            raise self.fails

    def is_kernel_driver_active(self, handle: str, interface: int) -> bool:
        return self.kernel

    def detach_kernel_driver(self, handle: str, interface: int) -> None:
        self.kernel = False

    def ctrl_transfer(self, handle: str, *setup: int | array[int]) -> int:
        kind, request, value, index, data, _timeout = setup
        assert isinstance(data, array)
        if self.fails is not None:
            raise self.fails
        assert not self.kernel, "the kernel's driver would refuse this transfer"
        if kind == 0xA1:
            report = array("B", b"RIG01\0\0" + bytes([self.state]))
            data[: self.report_bytes] = report[: self.report_bytes]
            return self.report_bytes
        self.written.append(((kind, request, value, index), bytes(data)))
        if self.obeys:
            bit = 1 << (data[1] - 1)
            self.state = self.state | bit if data[0] == 0xFF else self.state & ~bit
        return len(data)


def relay(bus: Bus) -> HidRelay:
    return HidRelay(channel=2, part="remote trigger", backend=bus)


def test_closing_and_opening_send_the_published_reports_and_are_read_back() -> None:
    bus = Bus()
    contact = relay(bus)
    contact.close_contact()
    assert contact.is_closed()
    assert bus.state == 0b10
    contact.open_contact()
    assert not contact.is_closed()
    assert bus.written == [SWITCH_ON_2, SWITCH_OFF_2]
    contact.close()
    contact.close()


def test_a_board_that_says_nothing_switched_is_an_error() -> None:
    bus = Bus()
    bus.obeys = False
    with pytest.raises(DeviceAnswerError, match="channel 2 does not switch"):
        relay(bus).close_contact()


def test_a_short_report_is_an_error() -> None:
    bus = Bus()
    bus.report_bytes = 5
    with pytest.raises(DeviceAnswerError, match="5 bytes"):
        relay(bus).check()


def test_no_board_is_absent() -> None:
    bus = Bus()
    bus.plugged = False
    with pytest.raises(DeviceAbsentError, match="16c0:05df"):
        relay(bus).check()


@pytest.mark.parametrize(
    ("fault", "named"),
    [
        (usb.core.USBTimeoutError("slow", None, errno.ETIMEDOUT), DeviceSilentError),
        (usb.core.USBError("pipe", None, errno.EPIPE), DeviceAnswerError),
        (usb.core.USBError("busy", None, errno.EBUSY), DeviceBusyError),
        (usb.core.USBError("gone", None, errno.ENODEV), DeviceAbsentError),
        (usb.core.USBError("denied", None, errno.EACCES), DeviceError),
    ],
)
def test_each_fault_of_the_bus_has_its_name(fault: Exception, named: type[DeviceError]) -> None:
    bus = Bus()
    bus.fails = fault
    with pytest.raises(named) as caught:
        relay(bus).check()
    assert type(caught.value) is named


def test_a_board_that_was_unplugged_works_again_when_it_is_back() -> None:
    bus = Bus()
    contact = relay(bus)
    contact.check()
    bus.fails = usb.core.USBError("gone", None, errno.ENODEV)
    with pytest.raises(DeviceAbsentError):
        contact.check()
    bus.fails, bus.kernel = None, True
    contact.check()
