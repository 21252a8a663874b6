"""A relay board 16c0:05df and a serial port (CDC-ACM), down to their descriptors."""

from __future__ import annotations

import struct
import time
from collections.abc import Callable

from simulators.wire.hid_relay import PRODUCT, VENDOR, HidRelay

_GET_DESCRIPTOR, _SET_CONFIGURATION, _SET_INTERFACE = 0x06, 0x09, 0x0B
_DEVICE, _CONFIGURATION, _STRING, _HID_REPORT = 1, 2, 3, 0x22


def _device(kind: int, vendor: int, product: int) -> bytes:
    return struct.pack(
        "<BBHBBBBHHHBBBB", 18, _DEVICE, 0x0110, kind, 0, 0, 64, vendor, product, 0x0100, 1, 2, 0, 1
    )


def _configuration(interfaces: int, body: bytes) -> bytes:
    head = struct.pack("<BBHBBBBB", 9, _CONFIGURATION, 9 + len(body), interfaces, 1, 0, 0x80, 50)
    return head + body


class _Described:
    device: bytes
    configuration: bytes
    report = b""

    def control(self, setup: tuple[int, int, int, int, int], data: bytes) -> bytes | None:
        kind, request, value, _, _ = setup
        if kind & 0x60:
            return self.own(setup, data)
        if request == _GET_DESCRIPTOR:
            return {
                _DEVICE: self.device,
                _CONFIGURATION: self.configuration,
                _STRING: b"\x04\x03\x09\x04" if value & 0xFF == 0 else b"\x08\x03R\0I\0G\0",
                _HID_REPORT: self.report,
            }.get(value >> 8)
        return b"" if request in {_SET_CONFIGURATION, _SET_INTERFACE} else None

    def own(self, setup: tuple[int, int, int, int, int], data: bytes) -> bytes | None:
        raise NotImplementedError

    def received(self, data: bytes) -> bytes:
        return b""


class RelayBoard(_Described):
    """The board with the class of a keyboard, so that the kernel's own driver takes it first."""

    device = _device(0, VENDOR, PRODUCT)
    # Usage page of a vendor, one feature report of 8 bytes.
    report = bytes.fromhex("0600ff0901a101150026ff0075089508090" + "0b102c0")
    configuration = _configuration(
        1,
        struct.pack("<9B", 9, 4, 0, 0, 1, 3, 0, 0, 0)
        + struct.pack("<BBHBBBH", 9, 0x21, 0x0110, 0, 1, 0x22, len(report))
        + struct.pack("<BBBBHB", 7, 5, 0x81, 3, 8, 10),
    )

    def __init__(self, relay: HidRelay) -> None:
        self._relay = relay

    def own(self, setup: tuple[int, int, int, int, int], data: bytes) -> bytes | None:
        kind, request, _, _, _ = setup
        if (kind, request) == (0x21, 0x09):
            self._relay.set_report(data)
            return b""
        if (kind, request) == (0xA1, 0x01):
            return self._relay.get_report()
        return b"" if kind == 0x21 else None  # SET_IDLE


class SerialAdapter(_Described):
    """A port that remembers when its modem lines moved, and answers whole lines."""

    device = _device(2, 0x1209, 0x0001)
    configuration = _configuration(
        2,
        struct.pack("<9B", 9, 4, 0, 0, 1, 2, 2, 1, 0)
        + bytes([5, 0x24, 0, 0x10, 1, 5, 0x24, 1, 0, 1, 4, 0x24, 2, 2, 5, 0x24, 6, 0, 1])
        + struct.pack("<BBBBHB", 7, 5, 0x81, 3, 8, 255)
        + struct.pack("<9B", 9, 4, 1, 0, 2, 10, 0, 0, 0)
        + struct.pack("<BBBBHB", 7, 5, 0x82, 2, 64, 0)
        + struct.pack("<BBBBHB", 7, 5, 0x03, 2, 64, 0),
    )

    def __init__(self, answer: Callable[[bytes], bytes]) -> None:
        self._answer = answer
        self._line = bytearray()
        self.lines: list[tuple[float, bool, bool]] = []

    def own(self, setup: tuple[int, int, int, int, int], data: bytes) -> bytes | None:
        _, request, value, _, length = setup
        if request == 0x22:  # SET_CONTROL_LINE_STATE
            self.lines.append((time.monotonic(), bool(value & 1), bool(value & 2)))
        if request == 0x21:
            return struct.pack("<IBBB", 115200, 0, 0, 8)[:length]
        return b""

    def received(self, data: bytes) -> bytes:
        self._line += data
        answers = b""
        while b"\n" in self._line:
            line, _, rest = bytes(self._line).partition(b"\n")
            self._line = bytearray(rest)
            answers += self._answer(line)
        return answers
