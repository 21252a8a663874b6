"""The USB relay 16c0:05df as the camera's remote trigger."""

from __future__ import annotations

import errno
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar

import usb.backend
import usb.core
import usb.util

from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceBusyError,
    DeviceError,
    DeviceSilentError,
)

VENDOR, PRODUCT = 0x16C0, 0x05DF

_ON, _OFF = 0xFF, 0xFD
_SET_REPORT = (0x21, 0x09, 0x0300, 0)
_GET_REPORT = (0xA1, 0x01, 0x0300, 0)
_REPORT_BYTES = 8
_STATE_BYTE = 7

_T = TypeVar("_T")


class HidRelay:
    """A `Closure` on one channel of the relay board; every switching is read back.

    The board is looked for at the first use and after it went away. Every method may be called
    from any thread.

    Parameters
    ----------
    channel
        Counted from 1, at most 8.
    backend
        pyusb backend; None takes the system's libusb.
    timeout_s
        Longest wait for one transfer; a switching needs two.
    """

    def __init__(
        self,
        *,
        channel: int,
        part: str = "remote trigger (hid-relay)",
        backend: usb.backend.IBackend | None = None,
        timeout_s: float = 0.5,
    ) -> None:
        self._channel, self._part, self._backend = channel, part, backend
        self._timeout_ms = round(timeout_s * 1000)
        self._lock = threading.RLock()
        self._device: usb.core.Device | None = None

    @property
    def name(self) -> str:
        """Role and driver."""
        return self._part

    def check(self) -> None:
        """Read the board's state.

        Raises
        ------
        DeviceAbsentError, DeviceBusyError, DeviceSilentError, DeviceAnswerError
            As the name says.
        """
        self.is_closed()

    def is_closed(self) -> bool:
        """Return whether the channel's contact is closed, as the board reports it."""
        request_type, request, value, index = _GET_REPORT
        report = self._transfer(
            lambda device: device.ctrl_transfer(
                request_type, request, value, index, _REPORT_BYTES, self._timeout_ms
            )
        )
        if len(report) != _REPORT_BYTES:
            raise DeviceAnswerError(
                "the state report has the wrong length",
                part=self._part,
                value=f"{len(report)} bytes",
                limit=f"{_REPORT_BYTES} bytes",
                todo="check that the board is a 16c0:05df relay",
            )
        return bool(report[_STATE_BYTE] >> (self._channel - 1) & 1)

    def close_contact(self) -> None:
        """Close the contact, hold it, and see that the board says so."""
        self._switch(True)

    def open_contact(self) -> None:
        """Open the contact and see that the board says so."""
        self._switch(False)

    def close(self) -> None:
        """Release the device; the contact stays as it is. Safe to call twice."""
        with self._lock:
            device, self._device = self._device, None
            if device is not None:
                # A board that went away cannot give back its interface.
                with suppress(usb.core.USBError):
                    usb.util.dispose_resources(device)

    def _switch(self, closed: bool) -> None:
        report = bytes((_ON if closed else _OFF, self._channel)).ljust(_REPORT_BYTES, b"\0")
        request_type, request, value, index = _SET_REPORT
        with self._lock:
            self._transfer(
                lambda device: device.ctrl_transfer(
                    request_type, request, value, index, report, self._timeout_ms
                )
            )
            if self.is_closed() != closed:
                raise DeviceAnswerError(
                    f"channel {self._channel} does not switch",
                    part=self._part,
                    value="open" if closed else "closed",
                    limit="closed" if closed else "open",
                    todo="check the board's supply and the channel in the configuration",
                )

    def _transfer(self, act: Callable[[usb.core.Device], _T]) -> _T:
        with self._lock:
            try:
                self._device = self._device or self._found()
                return act(self._device)
            except usb.core.USBError as error:
                raise self._named(error) from error

    def _found(self) -> usb.core.Device:
        try:
            device = usb.core.find(idVendor=VENDOR, idProduct=PRODUCT, backend=self._backend)
        except usb.core.NoBackendError as error:
            raise DeviceAbsentError(
                "libusb is not installed", part=self._part, todo="install libusb 1.0"
            ) from error
        if device is None:
            raise DeviceAbsentError(
                f"no USB device {VENDOR:04x}:{PRODUCT:04x}",
                part=self._part,
                todo="plug the relay board in",
            )
        # The kernel takes the board for a HID device and would refuse the transfers.
        if device.is_kernel_driver_active(0):
            device.detach_kernel_driver(0)
        return device

    def _named(self, error: usb.core.USBError) -> DeviceError:
        if isinstance(error, usb.core.USBTimeoutError):
            return DeviceSilentError(
                "the transfer was not answered",
                part=self._part,
                limit=f"{self._timeout_ms} ms",
                todo="unplug the board and plug it in again",
            )
        if error.errno == errno.EPIPE:
            return DeviceAnswerError(
                "the board refused the transfer",
                part=self._part,
                todo="check that the board is a 16c0:05df relay",
            )
        if error.errno == errno.EBUSY:
            return DeviceBusyError(
                "another program holds the board", part=self._part, todo="end the other program"
            )
        if error.errno == errno.EACCES:
            return DeviceError(
                "this user may not open the board", part=self._part, todo="add a udev rule"
            )
        self.close()
        return DeviceAbsentError(
            f"the board went away ({error.strerror})",
            part=self._part,
            todo="check the cable and plug the board in again",
        )
