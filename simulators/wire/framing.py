"""Cut a stream of bytes into the commands of a protocol."""

from __future__ import annotations

from typing import Protocol


class Framing(Protocol):
    """Assembles commands from whatever pieces the line delivers."""

    def feed(self, data: bytes) -> list[bytes]:
        """Return the commands that are complete with these bytes."""


class Lines:
    """Commands that end with one byte; the ending is taken off.

    Parameters
    ----------
    ending
        The last byte of a line.
    longest
        Length in bytes beyond which a line is thrown away up to its ending, as a device with a
        finite buffer does.
    """

    def __init__(self, ending: bytes, longest: int = 256) -> None:
        self._ending, self._longest = ending, longest
        self._partial = b""
        self._overlong = False

    def feed(self, data: bytes) -> list[bytes]:
        """Return the lines that are complete with these bytes, without their endings."""
        *complete, rest = (self._partial + data).split(self._ending)
        lines = []
        for line in complete:
            if not self._overlong and len(line) <= self._longest:
                lines.append(line)
            self._overlong = False
        self._overlong = self._overlong or len(rest) > self._longest
        self._partial = b"" if self._overlong else rest
        return lines
