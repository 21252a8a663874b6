"""LCUS relay boards: the cut-off, the two solenoids of the release apparatus, and the magnet."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Literal

from rigctl.devices.firing import not_sent, require_line
from rigctl.devices.roles import FireReceipt
from rigctl.devices.serial_port import SerialPort
from rigctl.errors import (
    DeviceError,
    FireOutcomeUnknownError,
    SettingsError,
)

BAUD = 9600
COMMAND_S = 4 * 10 / BAUD
"""Time of one command on the wire: four bytes of ten bits, 4.17 ms."""


def command(channel: int, on: bool) -> bytes:
    """Return the four bytes that switch one channel: A0, channel, state, their sum modulo 256.

    Raises
    ------
    ValueError
        The channel is no byte.

    Examples
    --------
    >>> command(1, True).hex(" ")
    'a0 01 01 a2'
    """
    head = bytes((0xA0, channel, int(on)))
    return head + bytes((sum(head) % 256,))


class LcusRelay:
    """A `CutOff` on one channel of an LCUS board.

    The actuators' supply runs through the normally open contact: a board without power, or a
    daemon that never ran, leaves them without supply. The board gives no answer, so its sign of
    life is that of its port.
    """

    def __init__(self, port: SerialPort, *, channel: int) -> None:
        self._port, self._channel = port, channel

    @property
    def name(self) -> str:
        """Role and driver."""
        return self._port.part

    def check(self) -> None:
        """See that the port is there; more the board does not tell."""
        self._port.discard_stale()

    def reopen(self) -> None:
        """See whether the port is there, and open it again if it was lost."""
        self._port.reopen_if_lost()

    def cut(self) -> None:
        """Open the contact at once, on a port opened again if it was lost."""
        self._port.reopen_if_lost()
        self._port.send(command(self._channel, False))

    def restore(self) -> None:
        """Close the contact."""
        self._port.send(command(self._channel, True))

    def close(self) -> None:
        """Release the port; the contact stays as it is. Safe to call twice."""
        self._port.close()


class Holders:
    """A `Trigger` of two solenoids on one LCUS board (thesis 3.2), or of one magnet (chapter 6).

    Both commands of a simultaneous fire leave in one write; the second channel still switches
    4.17 ms after the first, the time of its bytes on the wire. A delayed fire is timed by the
    host: no shorter than those 4.17 ms, and later by whatever the host's scheduler adds. The
    board confirms nothing; the receipt says only that the bytes left.

    Parameters
    ----------
    channel_a, channel_b
        Of each sphere's holder; b None: there is one only.
    energised
        What an energised solenoid does with its sphere. With ``"hold"`` the safe level is
        energised, and a power cut releases both spheres; with ``"release"`` the safe level is
        off, and a power cut holds them.
    clock, wait
        Monotonic seconds, and a wait in seconds.
    """

    def __init__(
        self,
        port: SerialPort,
        *,
        channel_a: int,
        channel_b: int | None,
        energised: Literal["hold", "release"],
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self._port, self._clock, self._wait = port, clock, wait
        self._channels = tuple(c for c in (channel_a, channel_b) if c is not None)
        self._firing_level = energised == "release"
        self._ready_for: int | None = None
        self._delay_us = 0.0

    @property
    def name(self) -> str:
        """Role and driver."""
        return self._port.part

    def check(self) -> None:
        """See that the port is there; more the board does not tell."""
        self._port.discard_stale()

    def reopen(self) -> None:
        """Open the port again if it was lost; the pair is then ready for no fire."""
        if self._port.reopen_if_lost():
            self._ready_for = None

    def arm(self, sequence: int, delay_us: float) -> None:
        """Hold the spheres and make ready for one fire, b `delay_us` after a.

        Raises
        ------
        SettingsError
            The delay is neither zero nor at least the time of one command, or there is no b.
        """
        if delay_us != 0 and len(self._channels) == 1:
            raise SettingsError(
                "one sphere alone has no delay",
                part=self.name,
                value=f"{delay_us:g} us",
                limit="0",
                todo="leave the delay out",
            )
        if 0 < abs(delay_us) < COMMAND_S * 1e6:
            raise SettingsError(
                "the delay is shorter than a command takes on the wire",
                part=self.name,
                value=f"{delay_us:g} us",
                limit=f"0, or at least {COMMAND_S * 1e6:.0f} us",
                todo="choose another delay",
            )
        self.make_safe()
        self._ready_for, self._delay_us = sequence, delay_us

    def fire(self, sequence: int) -> FireReceipt:
        """Switch every holder to its releasing level, once.

        Raises
        ------
        DeviceAnswerError
            No byte left: not armed under this number, or the port hung up before.
        FireOutcomeUnknownError
            The port failed while the bytes left; one solenoid, both or none may have released.
        """
        with self._port.held():
            if self._ready_for != sequence:
                raise not_sent(self.name, sequence, f"armed for {self._ready_for}")
            self._ready_for = None
            require_line(self._port, sequence)
            sent_at = self._clock()
            try:
                self._release(self._delay_us)
            except DeviceError as error:
                raise FireOutcomeUnknownError(
                    f"shot number {sequence} may have released none, one or both ({error})",
                    part=self.name,
                    todo="look at the tubes; the command is not sent again",
                ) from error
            return FireReceipt(sequence, sent_at, self._clock(), None)

    def make_safe(self) -> None:
        """Drive every channel to the level that holds its sphere."""
        self._ready_for = None
        self._port.send(b"".join(command(c, not self._firing_level) for c in self._channels))

    def close(self) -> None:
        """Release the port; the channels stay as they are. Safe to call twice."""
        self._port.close()

    def _release(self, delay_us: float) -> None:
        if delay_us == 0:
            self._port.send(b"".join(command(c, self._firing_level) for c in self._channels))
            return
        first, second = self._channels if delay_us > 0 else self._channels[::-1]
        began = self._clock()
        self._port.send(command(first, self._firing_level))
        self._wait(max(0.0, began + abs(delay_us) * 1e-6 - self._clock()))
        self._port.send(command(second, self._firing_level))
