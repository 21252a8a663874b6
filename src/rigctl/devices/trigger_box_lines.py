"""The trigger box's lines: closed by a checksum, taken apart into words, never guessed at."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import reduce
from operator import xor

from rigctl.errors import DeviceAnswerError

_CLOSED = re.compile(r"([^*\r\n]+)\*([0-9A-F]{2})")
_STATUS = re.compile(r"STAT (SAFE|ARMED) (\d{1,10}) (\d{1,10}) ([01])", re.ASCII)
_ADVICE = {
    "CUT": "restore the cut-off",
    "CHECKSUM": "check the cable and its screen",
    "LATE": "the box heard no heartbeat in time and made itself safe; release the rig",
    "BUSY": "wait for the end of the pulses of the last shot",
    "NOTARMED": "arm again; the box disarms itself 5 s after ARM",
}


@dataclass(frozen=True, slots=True)
class TriggerBoxStatus:
    """The box's answer to `STAT?`.

    Attributes
    ----------
    armed
        Ready for one fire.
    last_sequence
        The last number that fired; 0 when none has since power-on.
    fires
        Pulse pairs given since power-on.
    powered
        False when the cut-off has taken the power of the outputs.
    """

    armed: bool
    last_sequence: int
    fires: int
    powered: bool


def closed(text: str) -> str:
    """Return the line with `*` and its checksum: the exclusive-or of all bytes, as in NMEA 0183.

    Examples
    --------
    >>> closed("SAFE")
    'SAFE*11'
    """
    return f"{text}*{reduce(xor, text.encode('ascii'), 0):02X}"


def opened(line: str, part: str) -> str:
    """Return what a closed line says.

    Raises
    ------
    DeviceAnswerError
        There is no checksum, or it is not that of the line.
    """
    match = _CLOSED.fullmatch(line.removesuffix("\r"))
    if match is None or closed(match[1]) != match[0]:
        raise DeviceAnswerError(
            "the answer's checksum is absent or wrong",
            part=part,
            value=repr(line),
            todo="check the cable and its screen",
        )
    return match[1]


def status(text: str, part: str) -> TriggerBoxStatus:
    """Take apart the answer to `STAT?`.

    Raises
    ------
    DeviceAnswerError
        The words are not those of a status.
    """
    match = _STATUS.fullmatch(text)
    if match is None:
        raise unexpected(text, "STAT?", part)
    return TriggerBoxStatus(match[1] == "ARMED", int(match[2]), int(match[3]), match[4] == "1")


def unexpected(text: str, question: str, part: str) -> DeviceAnswerError:
    """Return the error for a whole line that is not the answer to this question."""
    _, _, refusal = text.partition("ERR ")
    if text.startswith("ERR "):
        return DeviceAnswerError(
            f"{question!r} was refused",
            part=part,
            value=refusal,
            todo=_ADVICE.get(refusal.partition(" ")[0], "see the trigger box's page"),
        )
    return DeviceAnswerError(
        f"{question!r} was answered by something else",
        part=part,
        value=repr(text),
        todo="check that a trigger box is on this port",
    )
