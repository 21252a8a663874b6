"""The RTS line of a serial port as the camera's remote trigger."""

from __future__ import annotations

from rigctl.devices.serial_port import SerialPort

BAUD = 9600


class SerialLine:
    """A `Closure` through an opto-coupler on RTS.

    The kernel raises RTS for a moment when it opens the port, and drops it when the port closes:
    the recorder may see one short closure when the daemon starts. Never put an actuator here.
    """

    def __init__(self, port: SerialPort) -> None:
        self._port = port

    @property
    def name(self) -> str:
        """Role and driver."""
        return self._port.part

    def check(self) -> None:
        """See that the port is there; nothing answers on a bare line."""
        self._port.reopen_if_lost()
        self._port.discard_stale()

    def close_contact(self) -> None:
        """Raise RTS and hold it."""
        self._port.set_rts(True)

    def open_contact(self) -> None:
        """Drop RTS."""
        self._port.set_rts(False)

    def close(self) -> None:
        """Release the port, which opens the contact. Safe to call twice."""
        self._port.close()
