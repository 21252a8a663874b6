"""Two Alicat pressure controllers on one bus."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

from rigctl.devices.roles import Reading
from rigctl.devices.serial_port import SerialPort
from rigctl.errors import DeviceAnswerError

BAUD = 19200
TERMINATOR = b"\r"
RESOLUTION_KPA = 0.01

_LINE = re.compile(r"([A-Z]) ([+-]?\d{1,6}\.\d{1,4}) ([+-]?\d{1,6}\.\d{1,4})", re.ASCII)


@dataclass(frozen=True, slots=True)
class AlicatLine:
    """One unit's answer: its letter, measured pressure and set point in kPa gauge."""

    unit: str
    pressure_kpa: float
    set_point_kpa: float


def parse(line: str, part: str, otherwise: str = "") -> AlicatLine:
    """Take apart an answer such as ``A +040.00 +040.00``.

    `otherwise` is what else to think of, beside the unit's own settings, if it is none.

    Raises
    ------
    DeviceAnswerError
        The line has another form; ``A ?`` means that the unit did not understand.
    """
    match = _LINE.fullmatch(line)
    if match is None:
        raise DeviceAnswerError(
            "the answer is no line of letter, pressure and set point",
            part=part,
            value=repr(line),
            todo="check the unit's letter, its units (kPa gauge) and the baud rate"
            + (f"; {otherwise}" if otherwise else ""),
        )
    return AlicatLine(match[1], float(match[2]), float(match[3]))


class AlicatPair:
    """A `Regulator` of two units on one bus.

    Set points are given in steps of 0.01 kPa, the resolution of the protocol's lines; the unit's
    echo must agree within one step.

    Parameters
    ----------
    port
        Opened port, 19200 baud, lines ended by a carriage return.
    unit_a, unit_b
        The letters of pusher a's and b's unit.
    clock
        Monotonic seconds, for the age of readings.
    """

    def __init__(
        self,
        port: SerialPort,
        *,
        unit_a: str,
        unit_b: str,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._port, self._clock = port, clock
        self._units = (unit_a, unit_b)

    @property
    def name(self) -> str:
        """Role and driver."""
        return self._port.part

    def check(self) -> None:
        """Read both units once."""
        self.pressure()

    def reopen(self) -> None:
        """See whether the port is there, and open it again if it was lost."""
        self._port.reopen_if_lost()

    def set_pressure(self, a_kpa: float, b_kpa: float) -> None:
        """Give both set points in kPa gauge; returns before the pressure has settled.

        Raises
        ------
        DeviceError
            A unit gave no answer, or echoed another set point; the other may be set already.
        """
        for unit, wanted in zip(self._units, (a_kpa, b_kpa), strict=True):
            self._set(unit, wanted)

    def vent(self) -> None:
        """Give both set points of 0 kPa; the second is given even when the first is not taken.

        Raises
        ------
        DeviceError
            A unit gave no answer, or echoed another set point.
        """
        with ExitStack() as both:
            for unit in self._units:
                both.callback(self._set, unit, 0.0)

    def pressure(self) -> tuple[Reading, Reading]:
        """Return the measured pressures of a and b in kPa gauge."""
        a, b = (self._read(unit) for unit in self._units)
        return a, b

    def close(self) -> None:
        """Release the port; the set points stay. Safe to call twice."""
        self._port.close()

    def _set(self, unit: str, wanted_kpa: float) -> None:
        echoed = self._ask(unit, f"{unit}S{wanted_kpa:.2f}").set_point_kpa
        if abs(echoed - wanted_kpa) > RESOLUTION_KPA:
            raise DeviceAnswerError(
                f"unit {unit} did not take the set point",
                part=self.name,
                value=f"{echoed:g} kPa",
                limit=f"{wanted_kpa:.2f} kPa",
                todo="check the unit's range and whether its front panel is locked",
            )

    def _read(self, unit: str) -> Reading:
        # The earliest moment the pressure can have been measured, so that no reading looks young.
        asked_at = self._clock()
        return Reading(self._ask(unit, unit).pressure_kpa, "kPa", asked_at)

    def _ask(self, unit: str, question: str) -> AlicatLine:
        answer = self._port.ask(question, late=lambda line: self._is_of_another(line, unit))
        return parse(answer, self.name, self._port.another)

    def _is_of_another(self, line: str, unit: str) -> bool:
        match = _LINE.fullmatch(line)
        return match is not None and match[1] != unit
