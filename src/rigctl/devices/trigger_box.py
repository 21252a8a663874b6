"""The trigger box: fires both pushers from one numbered command, at most once."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from operator import xor

from rigctl.devices.firing import not_sent, require_line
from rigctl.devices.roles import FireOutcome, FireReceipt
from rigctl.devices.serial_port import SerialPort
from rigctl.errors import (
    DeviceAnswerError,
    DeviceError,
    FireOutcomeUnknownError,
    SettingsError,
)

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


def opened(line: str, part: str, otherwise: str = "another device may be on the port") -> str:
    """Return what a closed line says.

    `otherwise` is what to think of, beside the cable, where it is not closed.

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
            todo=f"{otherwise}, or check the cable and its screen",
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
        todo="check that a trigger box is on this port: another device may be there",
    )


_log = logging.getLogger(__name__)

_IDENTITY = re.compile(r"RIGTRIG ([12]) 2", re.ASCII)
_HEARTBEAT_SINCE = 2
_BEAT_TIMEOUT_S = 0.3
"""Longest wait for the answer to a heartbeat: another must go out before the watch is late, s."""
_FIRED = re.compile(r"FIRED (\d{1,10}) (\d{1,20})", re.ASCII)
_FIRED_ALREADY = "ERR DUPLICATE"
_NOT_WATCHING = ("ERR LATE", "ERR NOWATCH")
_ANSWERS = ("ARMED ", "FIRED ", "STAT ", "SAFE", "RIGTRIG ", "WATCHING ", "BEAT")


class TriggerBox:
    """A `Trigger` behind the project's trigger box (wire-protocol reference).

    A fire command leaves at most once for each successful `arm`, in every case. The box answers in
    the order of its questions, and no question may have failed between `arm` and `fire`, so what
    answers a fire command cannot belong to an earlier one.

    Parameters
    ----------
    port
        Opened port, lines ended by a line feed.
    pulse_us
        Width of both pulses in microseconds.
    clock
        Monotonic seconds.
    """

    def __init__(
        self,
        port: SerialPort,
        *,
        pulse_us: int,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._port, self._pulse_us, self._clock = port, pulse_us, clock
        self._ready_for: int | None = None

    @property
    def name(self) -> str:
        """Role and driver."""
        return self._port.part

    def check(self) -> None:
        """Ask what is on the port.

        Raises
        ------
        DeviceError
            Nothing answers, or it is no trigger box of version 1 or 2 with two channels.
        """
        self._version()

    def reopen(self) -> None:
        """Open the port again if it was lost; the box is then ready for no fire."""
        with self._port.held():
            if self._port.reopen_if_lost():
                self._ready_for = None

    def status(self) -> TriggerBoxStatus:
        """Return what the box says of itself, power of the outputs included."""
        return status(self._ask("STAT?", kind="STAT "), self.name)

    def powered(self) -> bool:
        """Say whether the outputs have power."""
        return self.status().powered

    def firmware(self) -> str:
        """Return the box's identification: protocol version and channels."""
        return self._identity()[0]

    def arm(self, sequence: int, delay_us: float) -> None:
        """Make ready for one fire under this number, b `delay_us` after a.

        Raises
        ------
        SettingsError
            The delay is no whole number of microseconds.
        DeviceError
            The box refused or gave no answer; it is not armed, or disarms itself within 5 s.
        """
        if delay_us != round(delay_us):
            raise SettingsError(
                "the delay is finer than the box's clock",
                part=self.name,
                value=f"{delay_us!r} us",
                limit="whole microseconds",
                todo="round the delay",
            )
        self._expect(f"ARM {sequence} {round(delay_us)} {self._pulse_us}", f"ARMED {sequence}")
        self._ready_for = sequence

    def fire(self, sequence: int) -> FireReceipt:
        """Send the fire command once.

        Raises
        ------
        DeviceAnswerError
            It did not fire: the box is not armed under this number, the port hung up before the
            command left, or the box refused and its record confirms that.
        FireOutcomeUnknownError
            The command left and no clear answer came back; `outcome` may settle it.
        """
        with self._port.held():
            if self._ready_for != sequence:
                raise not_sent(self.name, sequence, f"armed for {self._ready_for}")
            self._ready_for = None
            require_line(self._port, sequence)
            sent_at = self._clock()
            try:
                text = self._ask(f"FIRE {sequence}", kind=f"FIRED {sequence} ")
            except DeviceError as error:
                raise self._unknown(sequence, str(error)) from error
            confirmed_at = self._clock()
            if match := _FIRED.fullmatch(text):
                return FireReceipt(sequence, sent_at, confirmed_at, int(match[2]))
            raise self._refused(sequence, text)

    def outcome(self, sequence: int) -> FireOutcome:
        """Ask what became of a fire command; asks once, fires nothing and never raises."""
        try:
            found = self.status()
        except DeviceError as error:
            _log.warning("%s: shot number %d is not settled: %s", self.name, sequence, error)
            return FireOutcome.UNKNOWN
        if found.last_sequence == sequence:
            return FireOutcome.FIRED
        # A box that the pulses themselves have reset is disarmed and remembers no number.
        remembers = found.armed or found.last_sequence > 0
        if remembers and found.last_sequence < sequence:
            return FireOutcome.NOT_FIRED
        return FireOutcome.UNKNOWN

    def watch(self, within_s: float) -> bool:
        """Have the box make itself safe where no `beat` comes within a time, rounded to ms.

        Returns
        -------
        bool
            False where the box is of version 1, which knows no heartbeat; nothing has changed.

        Raises
        ------
        DeviceError
            No answer, or a refusal.
        """
        if self._version() < _HEARTBEAT_SINCE:
            return False
        period_ms = round(1e3 * within_s)
        self._expect(f"WATCH {period_ms}", f"WATCHING {period_ms}")
        return True

    def beat(self) -> bool:
        """Tell the box that the host lives; return whether it still watches.

        False: the watch was late, or the box was started anew; it is safe until the next `watch`.

        Raises
        ------
        DeviceError
            No clear answer came.
        """
        text = self._ask("BEAT", kind="BEAT", timeout_s=_BEAT_TIMEOUT_S)
        if text.startswith(_NOT_WATCHING):
            self._ready_for = None
            return False
        if text != "BEAT":
            raise unexpected(text, "BEAT", self.name)
        return True

    def end_watch(self) -> None:
        """Have the box watch no more; it disarms, and its contact in the power's line opens."""
        self._expect("WATCH 0", "WATCHING 0")
        self._ready_for = None

    def make_safe(self) -> None:
        """Disarm; both outputs low. Harmless in any state."""
        self._expect("SAFE", "SAFE")
        self._ready_for = None

    def close(self) -> None:
        """Release the port. Safe to call twice."""
        self._port.close()

    def _version(self) -> int:
        return int(self._identity()[1])

    def _identity(self) -> re.Match[str]:
        text = self._ask("ID?", kind="RIGTRIG ")
        match = _IDENTITY.fullmatch(text)
        if match is None:
            raise unexpected(text, "ID?", self.name)
        return match

    def _expect(self, question: str, answer: str) -> None:
        text = self._ask(question, kind=answer)
        if text != answer:
            raise unexpected(text, question, self.name)

    def _ask(self, question: str, *, kind: str, timeout_s: float | None = None) -> str:
        with self._port.held():
            try:
                line = self._port.ask(
                    closed(question),
                    late=lambda line: self._is_late(line, kind),
                    timeout_s=timeout_s,
                )
                return opened(line, self.name, self._port.another)
            except DeviceError:
                self._ready_for = None
                raise

    def _is_late(self, line: str, kind: str) -> bool:
        try:
            text = opened(line, self.name)
        except DeviceAnswerError:
            return False
        return text.startswith(_ANSWERS) and not text.startswith(kind)

    def _refused(self, sequence: int, text: str) -> DeviceError:
        # A refusal carries no number: noise on the line may have earned it, and the command after
        # the noise may have fired. The box's own record decides.
        if text.startswith(_FIRED_ALREADY):
            return self._unknown(sequence, f"the box answered {text!r}")
        try:
            fired = self.status().last_sequence >= sequence
        except DeviceError as error:
            return self._unknown(sequence, f"the box answered {text!r}, then failed: {error}")
        if fired:
            return self._unknown(sequence, f"the box answered {text!r}, yet counts a fire")
        return unexpected(text, f"FIRE {sequence}", self.name)

    def _unknown(self, sequence: int, why: str) -> FireOutcomeUnknownError:
        return FireOutcomeUnknownError(
            f"shot number {sequence} may or may not have fired ({why})",
            part=self.name,
            todo="look at the tubes; the command is not sent again",
        )
