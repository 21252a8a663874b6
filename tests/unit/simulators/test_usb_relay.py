from __future__ import annotations

import errno

import pytest
import usb.core
from hypothesis import given
from hypothesis import strategies as st

from simulators.wire.hid_relay import HidRelay, HidRelayBackend

SET, GET = (0x21, 0x09, 0x0300, 0), (0xA1, 0x01, 0x0300, 0)


class Bench:
    def __init__(self, detached: bool = True) -> None:
        self.switched: list[tuple[int, bool]] = []
        self.relay = HidRelay(2, lambda channel, on: self.switched.append((channel, on)))
        self.backend = HidRelayBackend(self.relay)
        self.device = usb.core.find(idVendor=0x16C0, idProduct=0x05DF, backend=self.backend)
        if detached:
            self.device.detach_kernel_driver(0)

    def send(self, *report: int) -> int:
        return int(self.device.ctrl_transfer(*SET, bytes(report).ljust(8, b"\0"), 500))

    def read(self) -> bytes:
        return bytes(self.device.ctrl_transfer(*GET, 8, 500))


@pytest.mark.parametrize(
    ("reports", "state"),
    [
        ([], 0b00),
        ([(0xFF, 1)], 0b01),
        ([(0xFF, 2)], 0b10),
        ([(0xFF, 1), (0xFD, 1)], 0b00),
        ([(0xFE,)], 0b11),
        ([(0xFE,), (0xFC,)], 0b00),
        ([(0xFF, 3)], 0b00),
        ([(0xFF, 0)], 0b00),
        ([(0x00, 1)], 0b00),
    ],
)
def test_reports_switch_the_channels_and_the_state_reads_back(
    reports: list[tuple[int, ...]], state: int
) -> None:
    bench = Bench()
    assert [bench.send(*report) for report in reports] == [8] * len(reports)
    assert bench.read() == b"RIG01\0\0" + bytes([state])


def test_each_edge_is_told_once() -> None:
    bench = Bench()
    for report in ((0xFF, 1), (0xFF, 1), (0xFD, 1)):
        bench.send(*report)
    assert bench.switched == [(1, True), (1, False)]


def test_the_board_says_who_it_is() -> None:
    device = Bench().device
    assert (device.manufacturer, device.product) == ("www.dcttech.com", "USBRelay2")
    assert device[0][(0, 0)].bInterfaceClass == 3


def test_the_kernels_driver_must_be_detached_first() -> None:
    bench = Bench(detached=False)
    assert bench.device.is_kernel_driver_active(0)
    with pytest.raises(usb.core.USBError) as refused:
        bench.send(0xFF, 1)
    assert refused.value.errno == errno.EBUSY
    bench.device.detach_kernel_driver(0)
    bench.send(0xFF, 1)
    assert bench.switched == [(1, True)]


def test_timeouts_come_as_often_as_told_and_the_board_does_not_act() -> None:
    bench = Bench()
    bench.backend.fault("timeout", times=2)
    for _ in range(2):
        with pytest.raises(usb.core.USBTimeoutError):
            bench.send(0xFF, 1)
    assert bench.switched == []
    bench.send(0xFF, 1)
    assert bench.switched == [(1, True)]


def test_lasting_timeouts_last_until_cleared() -> None:
    bench = Bench()
    bench.backend.fault("timeout")
    for _ in range(5):
        with pytest.raises(usb.core.USBTimeoutError):
            bench.read()
    bench.backend.clear()
    assert bench.read()[7] == 0


def test_a_pulled_board_is_neither_reached_nor_found_until_plugged_in_again() -> None:
    bench = Bench()
    bench.backend.fault("disconnect")
    with pytest.raises(usb.core.USBError) as gone:
        bench.read()
    assert gone.value.errno == errno.ENODEV
    assert usb.core.find(idVendor=0x16C0, backend=bench.backend) is None
    bench.backend.clear()
    assert usb.core.find(idVendor=0x16C0, backend=bench.backend) is not None
    assert bench.backend.is_kernel_driver_active("", 0)


def test_a_stuck_relay_takes_reports_and_stays() -> None:
    bench = Bench()
    bench.relay.stick(True)
    assert bench.send(0xFF, 1) == 8
    assert bench.read()[7] == 0


@pytest.mark.parametrize(("kind", "times"), [("burn", None), ("timeout", 0), ("timeout", 1.5)])
def test_a_fault_that_cannot_be_is_refused(kind: str, times: int | None) -> None:
    with pytest.raises(ValueError, match=r"none of|allowed"):
        Bench().backend.fault(kind, times=times)


@given(report=st.binary(min_size=8, max_size=8))
def test_no_report_breaks_the_board(report: bytes) -> None:
    bench = Bench()
    bench.send(*report)
    assert bench.read()[:5] == b"RIG01"


@given(value=st.integers(0, 0xFFFF), request=st.integers(0, 255))
def test_an_unknown_request_stalls(value: int, request: int) -> None:
    bench = Bench()
    with pytest.raises(usb.core.USBError) as stalled:
        bench.device.ctrl_transfer(0xC0, request, value, 0, 8, 500)
    assert stalled.value.errno == errno.EPIPE
