"""The trigger box: two outputs fired by one numbered command."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable
from dataclasses import dataclass

from simulators.wire.watch import Watch

VERSION = 2
"""From this version on the box knows `WATCH` and `BEAT`."""
CHANNELS = 2
ARMED_FOR_S = 5.0
LARGEST_SEQUENCE = 2**32 - 1
LONGEST_DELAY_US = 100_000
PULSE_US = (100, 100_000)

_FRAME = re.compile(rb"([^*]*)\*([0-9A-F]{2})")
_ARM = re.compile(r"ARM (\d{1,10}) (-?\d{1,9}) (\d{1,9})", re.ASCII)
_FIRE = re.compile(r"FIRE (\d{1,10})", re.ASCII)
_WATCH = re.compile(r"WATCH (\d{1,5})", re.ASCII)


@dataclass(frozen=True, slots=True)
class Pulses:
    """Both outputs of one fire: when each rises, on the laboratory's clock, and for how long."""

    a_s: float
    b_s: float
    width_s: float


@dataclass(frozen=True, slots=True)
class _Arming:
    sequence: int
    delay_us: int
    width_us: int
    until_s: float


class TriggerBox:
    """A model of the trigger box in `docs/reference/wire-protocols.md`.

    Parameters
    ----------
    clock
        Laboratory time in seconds; the box's own clock counts from construction.
    output
        Called once for each fire with the pulses; its caller holds no lock.
    version
        1: a box of before the heartbeat.
    contact_in_power
        The watch's contact lies in the line of the outputs' power.

    Notes
    -----
    States: SAFE --ARM--> ARMED --FIRE, SAFE, power cut, late watch or 5 s--> SAFE. A refused
    command changes nothing. Any thread may call; the power comes from another device's thread.
    Pulses are put out whole: nothing that ends them early is simulated.
    """

    def __init__(
        self,
        clock: Callable[[], float],
        output: Callable[[Pulses], None],
        *,
        version: int = VERSION,
        contact_in_power: bool = False,
    ) -> None:
        self._clock, self._output, self._version = clock, output, version
        self._contact_in_power = contact_in_power
        self._power_on_s = clock()
        self._lock = threading.RLock()
        self._watch = Watch(clock)
        self._arming: _Arming | None = None
        self._powered = False
        self._last_sequence = 0
        self._fires = 0
        self._pulsing_until_s = clock()
        self._stuck = False

    def power(self, on: bool) -> None:
        """Give or take the outputs' power; taking it disarms."""
        with self._lock:
            self._powered = on
            if not on:
                self._disarm()

    @property
    def is_powered(self) -> bool:
        """Whether the outputs have power: from the cut-off, and through the contact if wired."""
        with self._lock:
            return self._powered and (not self._contact_in_power or self._watch.is_kept)

    @property
    def is_armed(self) -> bool:
        """Whether a fire command would fire."""
        with self._lock:
            return self._armed() is not None and self.is_powered

    @property
    def late_since_s(self) -> float | None:
        """When the watch became late; None: it is kept, or none is set."""
        with self._lock:
            return self._watch.late_since_s

    def stick(self, on: bool) -> None:
        """Answer as ever, with outputs that do nothing."""
        self._stuck = on

    def answer(self, line: bytes) -> bytes:
        """Answer one line (without its ending), checksum included."""
        frame = _FRAME.fullmatch(line)
        if frame is None:
            return _closed("ERR SYNTAX no checksum")
        if int(frame[2], 16) != checksum(frame[1]):
            return _closed(f"ERR CHECKSUM {checksum(frame[1]):02X}")
        command = frame[1].decode("ascii", errors="replace")
        if arm := _ARM.fullmatch(command):
            return _closed(self._arm(int(arm[1]), int(arm[2]), int(arm[3])))
        if fire := _FIRE.fullmatch(command):
            return _closed(self._fire(int(fire[1])))
        if self._version > 1 and (answer := self._heartbeat(command)):
            return _closed(answer)
        return _closed(self._plain(command))

    def _heartbeat(self, command: str) -> str | None:
        with self._lock:
            if command == "BEAT":
                return self._watch.beat()
            if watch := _WATCH.fullmatch(command):
                # What was armed before the watch was late, or ended, must not come back.
                if self._watch.late_since_s is not None or int(watch[1]) == 0:
                    self._disarm()
                return self._watch.set(int(watch[1]))
        return None

    def flash(self, version: int) -> None:
        """Say from now on that the firmware is of this version."""
        with self._lock:
            self._version = version

    def _plain(self, command: str) -> str:
        with self._lock:
            if command == "ID?":
                return f"RIGTRIG {self._version} {CHANNELS}"
            if command == "SAFE":
                self._disarm()
                return "SAFE"
            if command == "STAT?":
                state = "SAFE" if self._armed() is None else "ARMED"
                return f"STAT {state} {self._last_sequence} {self._fires} {int(self.is_powered)}"
        return "ERR SYNTAX unknown command"

    def _disarm(self) -> None:
        self._arming = None
        self._pulsing_until_s = self._clock()

    def _armed(self) -> _Arming | None:
        arming = self._arming
        if arming is None:
            return None
        if self._clock() >= arming.until_s or self._watch.late_since_s is not None:
            self._arming = None
        return self._arming

    def _unable(self) -> str | None:
        """Return why nothing can be armed or fired at all."""
        if self._watch.late_since_s is not None:
            return f"ERR LATE {self._watch.period_ms}"
        return None if self.is_powered else "ERR CUT no power"

    def _arm(self, sequence: int, delay_us: int, width_us: int) -> str:
        with self._lock:
            if refusal := _out_of_range(sequence, delay_us, width_us):
                return refusal
            if sequence == self._last_sequence:
                return f"ERR DUPLICATE {sequence}"
            if sequence < self._last_sequence:
                return f"ERR SEQUENCE above {self._last_sequence}"
            if refusal := self._unable():
                return refusal
            if self._clock() < self._pulsing_until_s:
                return "ERR BUSY pulses under way"
            until = self._clock() + ARMED_FOR_S
            self._arming = _Arming(sequence, delay_us, width_us, until)
            return f"ARMED {sequence}"

    def _fire(self, sequence: int) -> str:
        with self._lock:
            arming = self._armed()
            if self._last_sequence and sequence == self._last_sequence:
                return f"ERR DUPLICATE {sequence}"
            if refusal := self._unable():
                return refusal
            if arming is None:
                return "ERR NOTARMED no number"
            if sequence != arming.sequence:
                return f"ERR SEQUENCE {arming.sequence} is armed"
            self._arming = None
            self._last_sequence = sequence
            self._fires += 1
            first = self._clock()
            lasts_us = abs(arming.delay_us) + arming.width_us
            self._pulsing_until_s = first + lasts_us * 1e-6
        if not self._stuck:
            # Outside the lock: the cut-off must never wait for whatever the pulses set off.
            self._output(_pulses(first, arming))
        return f"FIRED {sequence} {round((first - self._power_on_s) * 1e6)}"


def _out_of_range(sequence: int, delay_us: int, width_us: int) -> str | None:
    if not 1 <= sequence <= LARGEST_SEQUENCE:
        return f"ERR RANGE sequence 1 to {LARGEST_SEQUENCE}"
    if abs(delay_us) > LONGEST_DELAY_US:
        return f"ERR RANGE delay within {LONGEST_DELAY_US} us"
    if not PULSE_US[0] <= width_us <= PULSE_US[1]:
        return f"ERR RANGE width {PULSE_US[0]} to {PULSE_US[1]} us"
    return None


def _pulses(first_s: float, arming: _Arming) -> Pulses:
    delay = arming.delay_us * 1e-6
    return Pulses(first_s + max(0.0, -delay), first_s + max(0.0, delay), arming.width_us * 1e-6)


def checksum(content: bytes) -> int:
    """Return the exclusive-or of every byte, as NMEA 0183 closes its sentences."""
    result = 0
    for byte in content:
        result ^= byte
    return result


def _closed(content: str) -> bytes:
    return f"{content}*{checksum(content.encode()):02X}\n".encode()
