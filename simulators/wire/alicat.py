"""Two pressure regulators on one bus, in Alicat's ASCII protocol."""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Callable
from dataclasses import dataclass

FULL_SCALE_KPA = 200.0
LAG_S = 0.03

_SET = re.compile(r"([A-Z])S(\d{1,4}(?:\.\d{1,4})?)", re.ASCII)


@dataclass(frozen=True, slots=True)
class _Approach:
    """First-order approach: p(t) = target + (start - target) exp(-(t - since) / lag)."""

    start_kpa: float
    target_kpa: float
    since_s: float

    def at(self, time_s: float, lag_s: float) -> float:
        passed = max(0.0, time_s - self.since_s)
        return self.target_kpa + (self.start_kpa - self.target_kpa) * math.exp(-passed / lag_s)


class PressureRegulator:
    """A model of the regulators in `docs/reference/wire-protocols.md`; they start without pressure.

    Parameters
    ----------
    clock
        Laboratory time in seconds.
    units
        The units' letters on the bus. Another letter gets no answer.
    lag_s
        Time constant of the approach to the set point in seconds.
    """

    def __init__(self, clock: Callable[[], float], units: str = "AB", lag_s: float = LAG_S) -> None:
        self._clock, self._lag_s = clock, lag_s
        self._lock = threading.Lock()
        self._pressures = {unit: _Approach(0.0, 0.0, clock()) for unit in units}
        self._set_points = dict.fromkeys(units, 0.0)
        self._stuck = False

    def pressure_kpa(self, unit: str, time_s: float) -> float:
        """Return a unit's gauge pressure in kPa at a laboratory time in seconds.

        The time is now or a moment ahead; the past before the last set point is forgotten.
        """
        with self._lock:
            return self._pressures[unit].at(time_s, self._lag_s)

    def stick(self, on: bool) -> None:
        """Hold the present pressures whatever the set points say; let go again."""
        with self._lock:
            self._stuck = on
            for unit in self._pressures:
                self._approach(unit)

    def answer(self, line: bytes) -> bytes:
        """Answer one line (without its carriage return)."""
        command = line.decode("ascii", errors="replace")
        unit = command[:1]
        if unit not in self._set_points:
            return b""
        with self._lock:
            order = _SET.fullmatch(command)
            if order and float(order[2]) <= FULL_SCALE_KPA:
                self._set_points[unit] = float(order[2])
                self._approach(unit)
            elif command != unit:
                return f"{unit} ?\r".encode()
            pressure = self._pressures[unit].at(self._clock(), self._lag_s)
            return f"{unit} {pressure:+07.2f} {self._set_points[unit]:+07.2f}\r".encode()

    def _approach(self, unit: str) -> None:
        now = self._clock()
        present = self._pressures[unit].at(now, self._lag_s)
        target = present if self._stuck else self._set_points[unit]
        self._pressures[unit] = _Approach(present, target, now)
