"""A Zaber stage as the offset slide, through the vendor's own library."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from zaber_motion import MotionLibException
from zaber_motion.ascii import Axis, Connection
from zaber_motion.exceptions import (
    CommandFailedException,
    ConnectionClosedException,
    ConnectionFailedException,
    RequestTimeoutException,
    SerialPortBusyException,
)

from rigctl.devices.roles import Reading
from rigctl.devices.serial_port import another_on
from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceBusyError,
    DeviceError,
    DeviceSilentError,
)

_log = logging.getLogger(__name__)

_POLL_S = 0.02


class ZaberSlide:
    """A `Slide` on device 1, axis 1 of a Zaber chain.

    Offsets count from the home sensor, in native microsteps of the stage. The library is asked
    not to identify the device, which would look it up in the vendor's database. A stage that was
    switched off does not know where it is: its position is refused, and the first move homes it.

    Parameters
    ----------
    port
        Device path of the chain, 115200 baud.
    microsteps_per_mm
        Of the stage's data sheet.
    answer_timeout_s
        Longest wait for one answer.
    home_timeout_s
        Longest search for the home sensor.
    clock, wait
        Monotonic seconds, and a wait in seconds.

    Raises
    ------
    DeviceBusyError, DeviceAbsentError
        The port is held by another program, or is not there.
    """

    def __init__(
        self,
        port: str,
        *,
        microsteps_per_mm: float,
        answer_timeout_s: float,
        part: str = "slide (zaber)",
        home_timeout_s: float = 30.0,
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self._path, self._part, self._steps = port, part, microsteps_per_mm
        self._answer_timeout_s, self._home_timeout_s = answer_timeout_s, home_timeout_s
        self._clock, self._wait = clock, wait
        self._reopening = threading.Lock()
        self._connection, self._axis = self._connected()

    @property
    def name(self) -> str:
        """Role and driver."""
        return self._part

    def check(self) -> None:
        """Ask the stage for its state.

        Raises
        ------
        DeviceError
            The stage gives no sign of life.
        """
        self.is_moving()

    def reopen(self) -> None:
        """Ask the stage for its state, and open the connection again if it was lost.

        Raises
        ------
        DeviceError
            The stage gives no sign of life.
        """
        with self._reopening:
            try:
                self.is_moving()
            except DeviceAbsentError:
                self.close()
                self._connection, self._axis = self._connected()

    def move_to(self, offset_mm: float) -> None:
        """Start a move to an offset in mm; a stage without reference is homed first.

        Raises
        ------
        DeviceError
            The stage refused (beyond its travel), was not found home, or gives no answer.
        """
        with self._errors_named(f"move to {offset_mm:g} mm"):
            if not self._axis.is_homed():
                self._home()
            self._axis.move_absolute(round(offset_mm * self._steps), wait_until_idle=False)

    def stop(self) -> None:
        """End a move, or a search for the home sensor, where it is; does not wait for the rest.

        Raises
        ------
        DeviceError
            The stage gives no answer.
        """
        with self._errors_named("stop"):
            self._axis.stop(wait_until_idle=False)

    def position(self) -> Reading:
        """Return the measured offset in mm.

        Raises
        ------
        DeviceAnswerError
            The stage has no reference since power-on: its count means nothing.
        """
        with self._errors_named("get pos"):
            asked_at = self._clock()
            if not self._axis.is_homed():
                raise DeviceAnswerError(
                    "the stage does not know where it is since power-on",
                    part=self._part,
                    todo="arm once: the first move homes it",
                )
            return Reading(self._axis.get_position() / self._steps, "mm", asked_at)

    def is_moving(self) -> bool:
        """Say whether a move is under way."""
        with self._errors_named("its state"):
            return self._axis.is_busy()

    def close(self) -> None:
        """Release the port; a move under way goes on. Safe to call twice."""
        self._connection.close()

    def _connected(self) -> tuple[Connection, Axis]:
        with self._errors_named("opening"):
            connection = Connection.open_serial_port(self._path, direct=True)
        try:
            with self._errors_named("its state"):
                connection.default_request_timeout = round(self._answer_timeout_s * 1000)
                axis = connection.get_device(1).get_axis(1)
                # The library's own search of the chain waits half a second whatever answers.
                axis.is_busy()
        except DeviceError:
            connection.close()
            raise
        return connection, axis

    def _home(self) -> None:
        _log.info("%s: homing, since the stage has no reference", self._part)
        deadline = self._clock() + self._home_timeout_s
        self._axis.home(wait_until_idle=False)
        while self._axis.is_busy():
            if self._clock() >= deadline:
                self._axis.stop(wait_until_idle=False)
                raise DeviceSilentError(
                    "the home sensor was not found and the stage was stopped",
                    part=self._part,
                    limit=f"{self._home_timeout_s:g} s",
                    todo="check that the slide moves freely",
                )
            self._wait(_POLL_S)
        if not self._axis.is_homed():
            raise DeviceAnswerError(
                "homing ended without a reference",
                part=self._part,
                todo="check that the slide moves freely, then switch the stage off and on",
            )

    @contextmanager
    def _errors_named(self, question: str) -> Iterator[None]:
        try:
            yield
        except MotionLibException as error:
            raise self._named(question, error) from error

    def _named(self, question: str, error: MotionLibException) -> DeviceError:
        match error:
            case RequestTimeoutException():
                return DeviceSilentError(
                    f"no answer to {question!r}",
                    part=self._part,
                    limit=f"{self._answer_timeout_s:g} s",
                    todo=f"check the cable and the power; {another_on(self._path)}",
                )
            case SerialPortBusyException():
                return DeviceBusyError(
                    f"{self._path} is held by another program",
                    part=self._part,
                    todo="end the other program and try again",
                )
            case ConnectionFailedException() | ConnectionClosedException():
                return DeviceAbsentError(
                    f"{self._path} is not there or went away",
                    part=self._part,
                    value=error.message,
                    todo="check the cable, the power and the port in the configuration",
                )
            case CommandFailedException():
                return DeviceAnswerError(
                    f"{question!r} was refused",
                    part=self._part,
                    value=error.message,
                    todo="check the travel of the stage and its warnings",
                )
            case _:
                return DeviceAnswerError(
                    f"{question!r} was not understood",
                    part=self._part,
                    value=error.message,
                    todo=f"{another_on(self._path)}",
                )
