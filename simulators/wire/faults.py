"""Faults on command, between a device's model and its port."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from simulators.wire.framing import Framing

HEX_DIGITS = b"0123456789ABCDEF"


class SerialFault(StrEnum):
    """What can go wrong on a serial line.

    `deaf` loses the command: the device does not act. `wrong-device`: another one sits on the port;
    nothing acts, and it answers in words of its own. All others act and spoil the answer.
    `disconnect` hangs up in place of the answer.
    """

    DEAF = "deaf"
    NO_ANSWER = "no-answer"
    HALF_ANSWER = "half-answer"
    GARBAGE = "garbage"
    LATE_ANSWER = "late-answer"
    DUPLICATE_ANSWER = "duplicate-answer"
    WRONG_CHECKSUM = "wrong-checksum"
    DISCONNECT = "disconnect"
    WRONG_DEVICE = "wrong-device"


@dataclass(frozen=True, slots=True)
class Answer:
    """Bytes for the host, sent after a time; or the end of the line."""

    data: bytes
    after_s: float = 0.0
    hang_up: bool = False


@dataclass(slots=True)
class _Setting:
    kind: SerialFault
    times: int | None
    delay_s: float
    command: bytes


class SerialFaults:
    """The faults one device has at present. Any thread may set, clear and take."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._settings: list[_Setting] = []

    def set(
        self, kind: str, *, times: int | None = None, delay_s: float = 0.2, command: str = ""
    ) -> None:
        """Add a fault.

        Parameters
        ----------
        kind
            One of `SerialFault`.
        times
            How many commands it strikes; None: every one until cleared.
        delay_s
            How late a late answer is, in seconds.
        command
            Strike only commands that contain this text.

        Raises
        ------
        ValueError
            An unknown kind, or a number that cannot be.
        """
        if kind not in set(SerialFault):
            raise ValueError(f"fault {kind!r} is none of {', '.join(SerialFault)}")
        require_count("times", times)
        if not 0 <= delay_s <= 60:
            raise ValueError(f"delay_s is {delay_s} s; allowed 0 to 60 s")
        with self._lock:
            self._settings.append(_Setting(SerialFault(kind), times, delay_s, command.encode()))

    def clear(self) -> None:
        """Remove every fault."""
        with self._lock:
            self._settings.clear()

    def take(self, command: bytes) -> tuple[SerialFault, float] | None:
        """Return the fault that strikes this command with its delay in seconds, and count it."""
        with self._lock:
            for setting in self._settings:
                if setting.command in command:
                    if setting.times is not None:
                        setting.times -= 1
                        if setting.times == 0:
                            self._settings.remove(setting)
                    return setting.kind, setting.delay_s
        return None


def require_count(name: str, value: int | None) -> None:
    """Raise `ValueError` unless the value is None or a whole number from 1 on."""
    if value is not None and (type(value) is not int or value < 1):
        raise ValueError(f"{name} is {value!r}; allowed are whole numbers from 1 on")


class SerialDevice:
    """A model behind its framing and its faults: bytes in, answers out.

    Parameters
    ----------
    framing
        Cuts the incoming bytes into commands.
    answer
        The model: one command in, the whole answer out (empty: the device says nothing).
    faults
        What goes wrong at present.
    """

    def __init__(
        self, framing: Framing, answer: Callable[[bytes], bytes], faults: SerialFaults
    ) -> None:
        self._framing, self._answer, self.faults = framing, answer, faults

    def receive(self, data: bytes) -> Sequence[Answer]:
        """Take bytes from the line and return the answers, in order."""
        answers = []
        for command in self._framing.feed(data):
            struck = self.faults.take(command)
            if struck is None:
                answers.append(Answer(self._answer(command)))
            elif struck[0] is SerialFault.WRONG_DEVICE:
                answers.append(Answer(_STRANGER))
            elif struck[0] is not SerialFault.DEAF:
                answers.append(_spoiled(self._answer(command), *struck))
        return answers


_STRANGER = b"ERROR\r\n"
"""What a modem says to whatever it does not know."""


def _spoiled(answer: bytes, kind: SerialFault, delay_s: float) -> Answer:
    if kind is SerialFault.DISCONNECT:
        return Answer(b"", hang_up=True)
    if kind is SerialFault.LATE_ANSWER:
        return Answer(answer, after_s=delay_s)
    return Answer(_SPOILED[kind](answer))


def _wrong_last_digit(answer: bytes) -> bytes:
    body = answer.rstrip(b"\r\n")
    if not body:
        return answer
    place = HEX_DIGITS.find(body[-1:])
    wrong = HEX_DIGITS[(place + 1) % 16 : (place + 1) % 16 + 1]
    return body[:-1] + wrong + answer[len(body) :]


def _noise(answer: bytes) -> bytes:
    """Return bytes with the top bit set, so no line ending: a line read at the wrong speed."""
    return bytes((byte ^ 0xA5) | 0x80 for byte in answer)


_SPOILED: dict[SerialFault, Callable[[bytes], bytes]] = {
    SerialFault.NO_ANSWER: lambda answer: b"",
    SerialFault.HALF_ANSWER: lambda answer: answer[: len(answer) // 2],
    SerialFault.GARBAGE: _noise,
    SerialFault.DUPLICATE_ANSWER: lambda answer: answer * 2,
    SerialFault.WRONG_CHECKSUM: _wrong_last_digit,
}
