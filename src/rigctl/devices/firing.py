"""What every trigger does before a fire command leaves, in the words that say it did not."""

from __future__ import annotations

from rigctl.devices.serial_port import SerialPort
from rigctl.errors import DeviceAnswerError, DeviceError


def not_sent(part: str, sequence: int, why: str) -> DeviceAnswerError:
    """Return the error for a fire command that never left the host."""
    return DeviceAnswerError(
        f"no fire command was sent for shot number {sequence}",
        part=part,
        value=why,
        todo="arm again",
    )


def require_line(port: SerialPort, sequence: int) -> None:
    """See that the port is there and hold nothing unread against the answer to come.

    Raises
    ------
    DeviceAnswerError
        The port hung up: nothing was sent.
    """
    try:
        port.discard_stale()
    except DeviceError as error:
        raise not_sent(port.part, sequence, str(error)) from error
