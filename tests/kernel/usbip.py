"""Devices of a few lines on the kernel's own virtual USB controller (vhci_hcd), over a socket.

Messages are those of the kernel's USB/IP protocol (Documentation/usb/usbip_protocol.rst), all
numbers big endian but those of the setup packet.
"""

from __future__ import annotations

import socket
import struct
import threading
import time
from collections import deque
from pathlib import Path
from typing import Protocol

CONTROLLER = Path("/sys/devices/platform/vhci_hcd.0")
FULL_SPEED = 2
_SUBMIT, _UNLINK, _SUBMITTED, _UNLINKED = 1, 2, 3, 4
_HEADER = struct.Struct(">5I5I")
_SETUP = struct.Struct("<BBHHH")
_STALL, _CANCELLED = -32, -104
_IN = 1
_ATTACH_S = 10.0


class Device(Protocol):
    """What a model must do."""

    def control(self, setup: tuple[int, int, int, int, int], data: bytes) -> bytes | None:
        """Answer a control transfer; None stalls."""

    def received(self, data: bytes) -> bytes:
        """Take bytes of the bulk endpoint; return those that answer."""


class Plug:
    """A device plugged into one port of the controller, until `pull`."""

    def __init__(self, port: int, device: Device) -> None:
        self._port, self._device = port, device
        self._ours, theirs = socket.socketpair()
        self._waiting: deque[int] = deque()
        self._ready = bytearray()
        self._lock = threading.Lock()
        line = f"{port} {theirs.fileno()} {1 << 16 | port + 2} {FULL_SPEED}"
        (CONTROLLER / "attach").write_text(line)
        theirs.close()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def pull(self) -> None:
        """Pull the plug; harmless when it is out."""
        if not self._thread.is_alive():
            return
        (CONTROLLER / "detach").write_text(str(self._port))
        self._thread.join(_ATTACH_S)
        self._ours.close()

    def _serve(self) -> None:
        try:
            while True:
                head = self._exactly(48)
                command, number, _, direction, endpoint, *rest = _HEADER.unpack(head[:40])
                if command == _SUBMIT:
                    length = rest[1]
                    data = self._exactly(length) if direction != _IN else b""
                    setup = _SETUP.unpack(head[40:])
                    self._submit(number, direction, endpoint, setup, data, length)
                elif command == _UNLINK:
                    self._unlink(number, cancelled=rest[0])
        except OSError:
            return

    def _submit(
        self,
        number: int,
        direction: int,
        endpoint: int,
        setup: tuple[int, int, int, int, int],
        data: bytes,
        length: int,
    ) -> None:
        if endpoint == 0:
            answer = self._device.control(setup, data)
            if answer is None:
                self._done(number, status=_STALL)
            elif direction == _IN:
                self._done(number, answer[:length])
            else:
                self._done(number, length=length)
        elif direction == _IN:
            # Held without an answer until there is something to say.
            if endpoint == 2:
                self._waiting.append(number)
                self._flush()
        else:
            self._ready += self._device.received(data)
            self._done(number, length=len(data))
            self._flush()

    def _flush(self) -> None:
        while self._waiting and self._ready:
            chunk, self._ready = bytes(self._ready[:64]), self._ready[64:]
            self._done(self._waiting.popleft(), chunk)

    def _unlink(self, number: int, cancelled: int) -> None:
        status = 0
        if cancelled in self._waiting:
            self._waiting.remove(cancelled)
            status = _CANCELLED
        self._send(struct.pack(">5Ii24x", _UNLINKED, number, 0, 0, 0, status))

    def _done(
        self, number: int, data: bytes = b"", *, status: int = 0, length: int | None = None
    ) -> None:
        size = len(data) if length is None else length
        head = struct.pack(
            ">5IiIIII8x", _SUBMITTED, number, 0, 0, 0, status, size, 0, 0xFFFFFFFF, 0
        )
        self._send(head + data)

    def _send(self, message: bytes) -> None:
        with self._lock:
            self._ours.sendall(message)

    def _exactly(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            chunk = self._ours.recv(count - len(data))
            if not chunk:
                raise OSError("the kernel has closed the line")
            data += chunk
        return data


def await_node(path: Path) -> None:
    """Wait until the kernel has made a device's node.

    Raises
    ------
    TimeoutError
        It has not within 10 s.
    """
    deadline = time.monotonic() + _ATTACH_S
    while not path.exists():
        if time.monotonic() > deadline:
            raise TimeoutError(f"no {path} after {_ATTACH_S:g} s")
        time.sleep(0.05)
