"""The LCUS relay board: four bytes switch a channel, and the board never answers."""

from __future__ import annotations

from collections.abc import Callable

START = 0xA0
COMMAND_SIZE = 4


class LcusFrames:
    """Finds four-byte commands with a right sum; a wrong byte is skipped, as the board does."""

    def __init__(self) -> None:
        self._partial = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Return the commands that are complete with these bytes."""
        self._partial += data
        commands = []
        while len(self._partial) >= COMMAND_SIZE:
            candidate = self._partial[:COMMAND_SIZE]
            if candidate[0] == START and sum(candidate[:3]) % 256 == candidate[3]:
                commands.append(candidate)
                self._partial = self._partial[COMMAND_SIZE:]
            else:
                self._partial = self._partial[1:]
        return commands


class LcusRelay:
    """A model of the board; all channels are off when power comes.

    Parameters
    ----------
    channels
        How many relays the board carries, numbered from 1.
    switched
        Called with channel and state when a relay changes.
    """

    def __init__(self, channels: int, switched: Callable[[int, bool], None]) -> None:
        self._states = [False] * channels
        self._switched = switched
        self._stuck = False

    def is_on(self, channel: int) -> bool:
        """Say whether a channel, numbered from 1, is on."""
        return self._states[channel - 1]

    def stick(self, on: bool) -> None:
        """Hold every relay where it is."""
        self._stuck = on

    def answer(self, command: bytes) -> bytes:
        """Take one whole command and answer nothing; an unknown channel or state is ignored."""
        channel, state = command[1], command[2]
        if not 1 <= channel <= len(self._states) or state not in (0, 1) or self._stuck:
            return b""
        if self._states[channel - 1] != bool(state):
            self._states[channel - 1] = bool(state)
            self._switched(channel, bool(state))
        return b""
