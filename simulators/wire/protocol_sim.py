"""`sim://NAME`: serial ports with modem lines, which pseudo-terminals have not.

pyserial finds this module by its name, in the packages that `serial.protocol_handler_packages`
lists. RTS behaves as on a kernel's terminal: opening the port raises it for a moment whatever
the host has preset, closing drops it.
"""

from __future__ import annotations

import errno
import threading
from collections.abc import Callable

import serial

SCHEME = "sim://"
PACKAGE = "simulators.wire"

_lock = threading.Lock()
_lines: dict[str, Callable[[bool], None]] = {}
_held: set[str] = set()


def publish(name: str, switched: Callable[[bool], None]) -> str:
    """Offer a port whose RTS line drives `switched`; return its URL."""
    if PACKAGE not in serial.protocol_handler_packages:
        serial.protocol_handler_packages.append(PACKAGE)
    with _lock:
        _lines[SCHEME + name] = switched
    return SCHEME + name


def withdraw(url: str) -> None:
    """Take a port away. Safe to call twice."""
    with _lock:
        _lines.pop(url, None)


class Serial(serial.SerialBase):
    """A port that carries RTS and nothing else: no bytes come, and those sent are lost."""

    def open(self) -> None:
        """Open the port, which raises RTS for a moment.

        Raises
        ------
        serial.SerialException
            The port is not there, is open, or is held exclusively.
        """
        url = str(self.port)
        with _lock:
            if url not in _lines:
                raise serial.SerialException(errno.ENOENT, f"could not open port {url}")
            if url in _held:
                raise serial.SerialException(errno.EAGAIN, f"could not lock port {url}")
            _held.add(url)
        self.is_open = True
        self._drive(True)
        self._update_dtr_state()
        self._update_rts_state()

    def close(self) -> None:
        """Close the port, which drops RTS. Safe to call twice."""
        if self.is_open:
            self.is_open = False
            with _lock:
                _held.discard(str(self.port))
                switched = _lines.get(str(self.port))
            if switched is not None:
                switched(False)

    @property
    def in_waiting(self) -> int:
        """Return how many bytes wait: none."""
        return 0

    def read(self, size: int = 1) -> bytes:
        """Wait for the port's time-out, in vain."""
        threading.Event().wait(self.timeout)
        return b""

    def write(self, data: bytes) -> int:  # type: ignore[override]  # any buffer, as bytes
        """Lose the bytes."""
        return len(data)

    def reset_input_buffer(self) -> None:
        """Do nothing: there is no input."""

    def reset_output_buffer(self) -> None:
        """Do nothing: output is lost at once."""

    def _reconfigure_port(self, force_update: bool = False) -> None:
        """Accept any line setting."""

    def _update_dtr_state(self) -> None:
        """Leave DTR, to which nothing is wired."""

    def _update_rts_state(self) -> None:
        self._drive(self.rts)

    def _drive(self, level: bool) -> None:
        with _lock:
            switched = _lines.get(str(self.port))
        if switched is None:
            raise serial.SerialException(errno.EIO, f"port {self.port} is gone")
        switched(level)
