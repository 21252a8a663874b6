"""The HID relay 16c0:05df as a USB device that pyusb reaches through a backend of its own."""

from __future__ import annotations

import errno
from array import array
from collections.abc import Callable, Iterator
from enum import StrEnum
from types import SimpleNamespace

import usb.backend
import usb.core

from simulators.wire.faults import require_count

VENDOR, PRODUCT = 0x16C0, 0x05DF
SERIAL = "RIG01"
REPORT_SIZE = 8
STRINGS = ("", "www.dcttech.com", "USBRelay2")

_GET_DESCRIPTOR = (0x80, 0x06)
_SET_REPORT = (0x21, 0x09, 0x0300, 0)
_GET_REPORT = (0xA1, 0x01, 0x0300, 0)
_ON, _OFF, _ALL_ON, _ALL_OFF = 0xFF, 0xFD, 0xFE, 0xFC


class HidRelay:
    """A model of the relay board; every channel is off when it is plugged in.

    Parameters
    ----------
    channels
        How many relays, numbered from 1.
    switched
        Called with channel and state when a relay changes.
    """

    def __init__(self, channels: int, switched: Callable[[int, bool], None]) -> None:
        self._states = [False] * channels
        self._switched = switched
        self._stuck = False

    def stick(self, on: bool) -> None:
        """Take every report and hold the relays where they are."""
        self._stuck = on

    def set_report(self, report: bytes) -> None:
        """Take one feature report; an unknown command or channel is ignored."""
        command, channel = report[0], report[1]
        if command in (_ALL_ON, _ALL_OFF):
            for each in range(1, len(self._states) + 1):
                self._switch(each, command == _ALL_ON)
        elif command in (_ON, _OFF) and 1 <= channel <= len(self._states):
            self._switch(channel, command == _ON)

    def get_report(self) -> bytes:
        """Return the serial number (five characters), two zeros and the state, bit 0 channel 1."""
        state = sum(on << place for place, on in enumerate(self._states))
        return SERIAL.encode() + bytes([0, 0, state])

    def _switch(self, channel: int, on: bool) -> None:
        if not self._stuck and self._states[channel - 1] != on:
            self._states[channel - 1] = on
            self._switched(channel, on)


class UsbFault(StrEnum):
    """What can go wrong on the bus: a transfer that gets no answer, a cable that is pulled."""

    TIMEOUT = "timeout"
    DISCONNECT = "disconnect"


class HidRelayBackend(usb.backend.IBackend):  # type: ignore[misc]  # pyusb has no types
    """A bus with one relay board, in the shape of a pyusb backend.

    As on Linux the kernel's HID driver holds the interface at first: who claims it must detach
    that driver before.
    """

    def __init__(self, relay: HidRelay) -> None:
        super().__init__()
        self._relay = relay
        self._kernel_holds = True
        self._timeouts: int | None = 0
        self._plugged = True

    def fault(self, kind: str, *, times: int | None = None) -> None:
        """Add a fault: a number of time-outs (None: lasting), or a disconnect until `clear`.

        Raises
        ------
        ValueError
            An unknown kind, or a number that cannot be.
        """
        if kind not in set(UsbFault):
            raise ValueError(f"fault {kind!r} is none of {', '.join(UsbFault)}")
        require_count("times", times)
        if kind == UsbFault.DISCONNECT:
            self._plugged = False
        else:
            self._timeouts = times

    def clear(self) -> None:
        """Remove every fault and plug the board in again."""
        if not self._plugged:
            self._kernel_holds = True
        self._timeouts, self._plugged = 0, True

    def enumerate_devices(self) -> Iterator[str]:
        """Yield the board while it is plugged in."""
        if self._plugged:
            yield SERIAL

    def get_device_descriptor(self, _device: str) -> SimpleNamespace:
        """Return the board's device descriptor."""
        return SimpleNamespace(
            bLength=18, bDescriptorType=1, bcdUSB=0x0110, bDeviceClass=0, bDeviceSubClass=0,
            bDeviceProtocol=0, bMaxPacketSize0=8, idVendor=VENDOR, idProduct=PRODUCT,
            bcdDevice=0x0100, iManufacturer=1, iProduct=2, iSerialNumber=0,
            bNumConfigurations=1, address=4, bus=1, port_number=1, port_numbers=(1,), speed=1,
        )  # fmt: skip

    def get_configuration_descriptor(self, _device: str, configuration: int) -> SimpleNamespace:
        """Return the board's only configuration."""
        _only(configuration)
        return SimpleNamespace(
            bLength=9, bDescriptorType=2, wTotalLength=34, bNumInterfaces=1,
            bConfigurationValue=1, iConfiguration=0, bmAttributes=0x80, bMaxPower=10,
            extra_descriptors=b"",
        )  # fmt: skip

    def get_interface_descriptor(
        self, _device: str, interface: int, alternate: int, configuration: int
    ) -> SimpleNamespace:
        """Return the board's only interface, of the HID class."""
        _only(interface, alternate, configuration)
        return SimpleNamespace(
            bLength=9, bDescriptorType=4, bInterfaceNumber=0, bAlternateSetting=0,
            bNumEndpoints=1, bInterfaceClass=3, bInterfaceSubClass=0, bInterfaceProtocol=0,
            iInterface=0, extra_descriptors=b"",
        )  # fmt: skip

    def get_endpoint_descriptor(
        self, _device: str, endpoint: int, interface: int, alternate: int, configuration: int
    ) -> SimpleNamespace:
        """Return the board's interrupt endpoint, which it never uses."""
        _only(endpoint, interface, alternate, configuration)
        return SimpleNamespace(
            bLength=7, bDescriptorType=5, bEndpointAddress=0x81, bmAttributes=3,
            wMaxPacketSize=8, bInterval=20, bRefresh=0, bSynchAddress=0, extra_descriptors=b"",
        )  # fmt: skip

    def open_device(self, device: str) -> str:
        """Return the board itself as its handle."""
        self._require_plugged()
        return device

    def close_device(self, _handle: str) -> None:
        """Do nothing: the board keeps no record of who opened it."""

    def get_configuration(self, _handle: str) -> int:
        """Return the active configuration."""
        return 1

    def set_configuration(self, _handle: str, configuration: int) -> None:
        """Accept the only configuration there is."""
        _only(configuration - 1)

    def claim_interface(self, _handle: str, _interface: int) -> None:
        """Claim the interface; busy while the kernel's driver holds it."""
        self._require_plugged()
        if self._kernel_holds:
            raise usb.core.USBError("Resource busy", None, errno.EBUSY)

    def release_interface(self, _handle: str, _interface: int) -> None:
        """Release the interface."""

    def is_kernel_driver_active(self, _handle: str, _interface: int) -> bool:
        """Say whether the kernel's HID driver holds the interface."""
        return self._kernel_holds

    def detach_kernel_driver(self, _handle: str, _interface: int) -> None:
        """Take the interface from the kernel's driver."""
        self._kernel_holds = False

    def attach_kernel_driver(self, _handle: str, _interface: int) -> None:
        """Give the interface back to the kernel's driver."""
        self._kernel_holds = True

    def ctrl_transfer(
        self,
        _handle: str,
        request_type: int,
        request: int,
        value: int,
        index: int,
        data: array[int],
        _timeout: int,
    ) -> int:
        """Serve one control transfer; incoming data fill `data` in place.

        Raises
        ------
        usb.core.USBTimeoutError
            A time-out fault struck; the board did not act.
        usb.core.USBError
            The board is unplugged, or stalls because it does not know the request.
        """
        self._require_plugged()
        self._strike()
        if (request_type, request) == _GET_DESCRIPTOR and value >> 8 == 3:
            return _fill(data, _string(value & 0xFF))
        if (request_type, request, value, index) == _GET_REPORT:
            return _fill(data, self._relay.get_report())
        if (request_type, request, value, index) == _SET_REPORT and len(data) == REPORT_SIZE:
            self._relay.set_report(bytes(data))
            return REPORT_SIZE
        raise usb.core.USBError("Pipe error", None, errno.EPIPE)

    def _require_plugged(self) -> None:
        if not self._plugged:
            raise usb.core.USBError("No such device", None, errno.ENODEV)

    def _strike(self) -> None:
        if self._timeouts != 0:
            if self._timeouts is not None:
                self._timeouts -= 1
            raise usb.core.USBTimeoutError("Operation timed out", None, errno.ETIMEDOUT)


def _only(*indices: int) -> None:
    if any(indices):
        raise IndexError(f"descriptor {indices} of a device with one of each")


def _string(index: int) -> bytes:
    if index == 0:
        return bytes([4, 3, 0x09, 0x04])
    if index >= len(STRINGS):
        raise usb.core.USBError("Pipe error", None, errno.EPIPE)
    text = STRINGS[index].encode("utf-16-le")
    return bytes([2 + len(text), 3]) + text


def _fill(data: array[int], answer: bytes) -> int:
    count = min(len(data), len(answer))
    data[:count] = array("B", answer[:count])
    return count
