"""A one-axis stage in Zaber's ASCII protocol, as far as its client library asks."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable
from dataclasses import dataclass

DEVICE_NUMBER = 1
TRAVEL_MM = 25.4
MICROSTEPS_PER_MM = 2015.75
SPEED_MM_PER_S = 100.0
STARTS_AT_MM = 2.0

_REQUEST = re.compile(
    r"/(?:(?P<device>\d{1,2})(?: (?P<axis>\d{1,2})(?: (?P<id>\d{1,2}))?)?)?"
    r" ?(?P<command>[a-z][a-z. 0-9-]*)?(?::(?P<sum>[0-9A-F]{2}))?",
    re.ASCII,
)
_MOVE = re.compile(r"move (abs|rel) (-?\d{1,9})", re.ASCII)


@dataclass(frozen=True, slots=True)
class _Move:
    """Uniform motion between two positions in microsteps."""

    start: float
    target: float
    since_s: float
    speed: float

    def at(self, time_s: float) -> float:
        way = self.target - self.start
        covered = min(abs(way), max(0.0, time_s - self.since_s) * self.speed)
        return self.start + (covered if way >= 0 else -covered)

    def ended(self, time_s: float) -> bool:
        return self.at(time_s) == self.target


class ZaberStage:
    """A model of the slide: device 1, axis 1, positions in microsteps from the home sensor.

    Parameters
    ----------
    clock
        Laboratory time in seconds.
    speed_mm_per_s
        Speed of every move.

    Notes
    -----
    After power-on the stage does not know where it is: it warns WR and refuses moves to an
    absolute position until it was homed. A command with a wrong checksum gets no answer.
    """

    def __init__(self, clock: Callable[[], float], speed_mm_per_s: float = SPEED_MM_PER_S) -> None:
        self._clock = clock
        self._speed = speed_mm_per_s * MICROSTEPS_PER_MM
        self._lock = threading.Lock()
        start = STARTS_AT_MM * MICROSTEPS_PER_MM
        self._move = _Move(start, start, clock(), self._speed)
        self._referenced = False
        self._homing = False
        self._stuck = False

    def position_mm(self, time_s: float) -> float:
        """Return where the carriage stands, in mm from the home sensor, at a laboratory time."""
        with self._lock:
            return self._move.at(time_s) / MICROSTEPS_PER_MM

    def stick(self, on: bool) -> None:
        """Accept moves and stay where it is; let go again, still at rest."""
        with self._lock:
            self._at_rest()
            self._stuck = on
            self._go(self._move.at(self._clock()))

    def answer(self, line: bytes) -> bytes:
        """Answer one line (without its line feed)."""
        request = _REQUEST.fullmatch(line.decode("ascii", errors="replace").strip("\r"))
        if request is None or not _sum_is_right(line, request["sum"]):
            return b""
        if int(request["device"] or 0) not in (0, DEVICE_NUMBER):
            return b""
        axis = int(request["axis"] or 0)
        with self._lock:
            verdict, data = self._obey(request["command"] or "", axis)
            return self._reply(axis, request["id"], verdict, data)

    def _reply(self, axis: int, identity: str | None, verdict: str, data: str) -> bytes:
        mark = f" {identity}" if identity else ""
        status = "IDLE" if self._at_rest() else "BUSY"
        warning = "--" if self._referenced else "WR"
        head = f"@{DEVICE_NUMBER:02d} {axis}{mark} {verdict} {status} {warning} {data}"
        return f"{head}\r\n".encode()

    def _at_rest(self) -> bool:
        """Say whether no move is under way; a search for home that has ended gave a reference."""
        rest = self._move.ended(self._clock())
        if rest and self._homing:
            self._homing, self._referenced = False, not self._stuck
        return rest

    def _obey(self, command: str, axis: int) -> tuple[str, str]:
        if axis > 1:
            return "RJ", "BADAXIS"
        self._at_rest()
        if move := _MOVE.fullmatch(command):
            return self._travel(move[1], int(move[2]))
        if command == "home":
            self._homing = True
            self._go(0.0)
            return "OK", "0"
        if command in ("stop", "estop"):
            self._homing = False
            self._go(self._move.at(self._clock()))
            return "OK", "0"
        return self._tell(command)

    def _tell(self, command: str) -> tuple[str, str]:
        settings = {
            "": "0",
            "get pos": str(round(self._counted())),
            "get limit.min": "0",
            "get limit.max": str(round(TRAVEL_MM * MICROSTEPS_PER_MM)),
            "get deviceid": "50081",
            "get version": "7.35",
            "get system.axiscount": "1",
            "get system.serial": "1000",
            "get comm.packet.size.max": "80",
            "warnings": "00" if self._referenced else "01 WR",
            "warnings clear": "00" if self._referenced else "01 WR",
        }
        if command in settings:
            return "OK", settings[command]
        return "RJ", "BADCOMMAND"

    def _counted(self) -> float:
        """Return the position as the stage believes it; power-on counts from where it stands."""
        position = self._move.at(self._clock())
        return position if self._referenced else position - STARTS_AT_MM * MICROSTEPS_PER_MM

    def _travel(self, kind: str, microsteps: int) -> tuple[str, str]:
        if not self._referenced:
            return "RJ", "BADCOMMAND"
        target = microsteps if kind == "abs" else self._move.at(self._clock()) + microsteps
        if not 0 <= target <= round(TRAVEL_MM * MICROSTEPS_PER_MM):
            return "RJ", "BADDATA"
        self._homing = False
        self._go(float(target))
        return "OK", "0"

    def _go(self, target: float) -> None:
        now = self._clock()
        start = self._move.at(now)
        self._move = _Move(start, start if self._stuck else target, now, self._speed)


def _sum_is_right(line: bytes, given: str | None) -> bool:
    """Say whether bytes and checksum add to zero modulo 256; no checksum is right as well."""
    if given is None:
        return True
    content = line[line.index(b"/") + 1 : line.rindex(b":")]
    return (sum(content) + int(given, 16)) % 256 == 0
