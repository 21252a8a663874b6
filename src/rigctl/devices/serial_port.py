"""One serial port: opened once, held open, one question at a time, every failure by its name."""

from __future__ import annotations

import errno
import logging
import termios
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import serial

from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceBusyError,
    DeviceError,
    DeviceSilentError,
)

_log = logging.getLogger(__name__)

_SLICE_S = 0.02
_LONGEST_DRAIN = 65536
_BUSY = {errno.EAGAIN, errno.EBUSY}
# pyserial passes some of the terminal's own errors on as they are; they are no OSError.
_LINE_FAILED = (OSError, termios.error)
_FORBIDDEN = {errno.EPERM, errno.EACCES}


def another_on(url: str) -> str:
    """Return what to think of where a port is there and nobody answers on it as is due."""
    return f"another device may be on {url}: compare it with the ports of the configuration"


class SerialPort:
    """A transport of bytes and lines; it knows no device.

    The port is opened in the constructor, for this process alone, with DTR and RTS preset low,
    and stays open: on many adapters the kernel raises both lines for a moment at every open.
    A port that hung up stays shut until `reopen_if_lost`; no question and no command opens it.

    Every method may be called from any thread. One lock makes a question and its answer one
    step; it is held for at most the write and answer times together.

    Parameters
    ----------
    url
        Device path or pyserial URL.
    part
        How errors call the device.
    baud
        Bits per second; always 8 data bits, no parity, 1 stop bit.
    answer_timeout_s
        Longest wait for a complete answer, and for the port to take the bytes of a question.
    terminator
        What ends a line in both directions.
    longest_line
        Bytes after which a line without an end is refused.

    Raises
    ------
    DeviceBusyError, DeviceAbsentError, DeviceError
        The port is held by another program, is not there, or may not be opened.
    """

    def __init__(
        self,
        url: str,
        *,
        part: str,
        baud: int,
        answer_timeout_s: float,
        terminator: bytes = b"\n",
        longest_line: int = 1024,
    ) -> None:
        self.part = part
        self._url, self._terminator, self._timeout_s = url, terminator, answer_timeout_s
        self._longest_line = longest_line
        self._lock = threading.RLock()
        self._unread = bytearray()
        self._lost = False
        try:
            self._serial = serial.serial_for_url(
                url,
                do_not_open=True,
                baudrate=baud,
                timeout=_SLICE_S,
                write_timeout=answer_timeout_s,
                exclusive=True,
            )
        except ValueError as error:
            raise DeviceAbsentError(
                f"{url} is no serial port",
                part=part,
                todo="correct the port in the configuration",
            ) from error
        self._serial.dtr = False
        self._serial.rts = False
        self._open()

    @property
    def another(self) -> str:
        """What to think of an answer that is none of the device's protocol."""
        return another_on(self._url)

    @contextmanager
    def held(self) -> Iterator[None]:
        """Keep other threads off the port for the length of a `with` block."""
        with self._lock:
            yield

    def ask(
        self,
        question: str,
        *,
        late: Callable[[str], bool] = lambda line: False,
        timeout_s: float | None = None,
    ) -> str:
        """Send one line and return the line that answers it, both without terminator.

        Input that waits before the question is sent answers nothing that was asked now: it is
        thrown away, logged, and named in the error if the question fails.

        Parameters
        ----------
        late
            Says of a line that it is whole but answers an earlier question; such lines are
            logged and passed over.
        timeout_s
            Wait this long for this answer instead of the port's own time.

        Raises
        ------
        DeviceSilentError
            Nothing, or only late answers, came in time.
        DeviceAnswerError
            Half a line, an endless line, or bytes that are not ASCII came.
        DeviceAbsentError
            The port hung up, before or after the question left.
        """
        waited = self._timeout_s if timeout_s is None else timeout_s
        with self._lock:
            stale = self.discard_stale()
            self._write(question.encode("ascii") + self._terminator)
            deadline = time.monotonic() + waited
            passed_over: list[str] = []
            while True:
                line = self._line_before(deadline, question, waited, stale, passed_over)
                if not late(line):
                    return line
                _log.warning("%s: late answer %r passed over", self.part, line)
                passed_over.append(line)

    def send(self, data: bytes) -> None:
        """Write bytes to a device that never answers; return once they have left the host.

        Raises
        ------
        DeviceAbsentError, DeviceSilentError
            The port hung up or did not take the bytes in time; some may have left.
        """
        with self._lock:
            self._write(data)

    def discard_stale(self) -> bytes:
        """Throw away input that nobody asked for, log it, and return it.

        Raises
        ------
        DeviceAbsentError
            The port hung up.
        """
        with self._lock:
            while len(self._unread) < _LONGEST_DRAIN and (chunk := self._read_waiting()):
                self._unread += chunk
            stale = bytes(self._unread)
            self._unread.clear()
        if stale:
            _log.warning("%s: threw away %r, which answers no question", self.part, stale)
        return stale

    def set_rts(self, level: bool) -> None:
        """Drive the RTS line; true is the asserted level.

        Raises
        ------
        DeviceError
            The port has no modem lines, or hung up.
        """
        with self._lock:
            self._require_open()
            try:
                self._serial.rts = level
            except OSError as error:
                if error.errno in {errno.ENOTTY, errno.EINVAL}:
                    raise DeviceError(
                        f"{self._url} has no RTS line",
                        part=self.part,
                        todo="name a port with modem lines in the configuration",
                    ) from error
                raise self._hung_up() from error

    def reopen_if_lost(self) -> bool:
        """Look whether the port hung up, and open it again if so; return whether it was opened.

        Raises
        ------
        DeviceBusyError, DeviceAbsentError, DeviceError
            As when the port was first opened.
        """
        with self._lock:
            if self._serial.is_open:
                try:
                    _ = self._serial.in_waiting
                except _LINE_FAILED as error:
                    _log.warning("%s", self._hung_up(), exc_info=error)
            if not self._lost:
                return False
            self._open()
            return True

    def close(self) -> None:
        """Release the port. Safe to call twice."""
        with self._lock:
            self._lost = False
            self._serial.close()

    def _open(self) -> None:
        try:
            self._serial.open()
        except _LINE_FAILED as error:
            raise self._refused_open(error) from error
        self._lost = False
        self._unread.clear()

    def _refused_open(self, error: OSError | termios.error) -> DeviceError:
        number = error.errno if isinstance(error, OSError) else None
        if number in _BUSY:
            return DeviceBusyError(
                f"{self._url} is held by another program",
                part=self.part,
                todo="end the other program, or a second daemon, and try again",
            )
        if number in _FORBIDDEN:
            return DeviceError(
                f"this user may not open {self._url}",
                part=self.part,
                todo="add the user to the group that owns the port",
            )
        return DeviceAbsentError(
            f"{self._url} cannot be opened ({error})",
            part=self.part,
            todo="check the cable, the power and the port in the configuration",
        )

    def _require_open(self) -> None:
        if not self._serial.is_open:
            raise DeviceAbsentError(
                f"{self._url} is closed since it hung up" if self._lost else "the port is closed",
                part=self.part,
                todo="check the cable and the power, then arm or release the rig",
            )

    def _hung_up(self) -> DeviceAbsentError:
        self._lost = True
        self._unread.clear()
        self._serial.close()
        return DeviceAbsentError(
            f"{self._url} hung up",
            part=self.part,
            todo="check the cable and the power",
        )

    def _write(self, data: bytes) -> None:
        self._require_open()
        try:
            self._serial.write(data)
            self._drain()
        except serial.SerialTimeoutException as error:
            raise DeviceSilentError(
                f"{self._url} does not take {data!r}",
                part=self.part,
                limit=f"{self._timeout_s:g} s",
                todo=f"check the cable and the power; {self.another}",
            ) from error
        except _LINE_FAILED as error:
            raise self._hung_up() from error

    def _drain(self) -> None:
        """Wait until the last byte has left.

        A signal to this thread (a child that ended, a debugger) breaks that wait off, and nothing
        takes it up again but this; the bytes themselves are with the kernel and sent once.
        """
        until = time.monotonic() + self._timeout_s
        while True:
            try:
                self._serial.flush()
            except termios.error as error:
                if error.args[0] != errno.EINTR or time.monotonic() >= until:
                    raise
            else:
                return

    def _read_waiting(self) -> bytes:
        self._require_open()
        try:
            return self._serial.read(waiting) if (waiting := self._serial.in_waiting) else b""
        except _LINE_FAILED as error:
            raise self._hung_up() from error

    def _read_slice(self) -> bytes:
        try:
            return self._serial.read(max(1, self._serial.in_waiting))
        except _LINE_FAILED as error:
            raise self._hung_up() from error

    def _line_before(
        self, deadline: float, question: str, waited_s: float, stale: bytes, late: list[str]
    ) -> str:
        while self._terminator not in self._unread and len(self._unread) < self._longest_line:
            # What has come by now counts, however late it is seen: this host may have been busy.
            over = time.monotonic() >= deadline
            chunk = self._read_waiting() if over else self._read_slice()
            if over and not chunk:
                raise self._no_answer(question, waited_s, stale, late)
            self._unread += chunk
        line, end, rest = bytes(self._unread).partition(self._terminator)
        self._unread[:] = rest
        if not end or not line.isascii():
            raise DeviceAnswerError(
                f"the answer to {question!r} is no line of ASCII{_before(stale, late)}",
                part=self.part,
                value=repr(line),
                todo=f"{self.another}, or check cable, baud rate and earth connection",
            )
        return line.decode("ascii")

    def _no_answer(
        self, question: str, waited_s: float, stale: bytes, late: list[str]
    ) -> DeviceError:
        half = bytes(self._unread)
        self._unread.clear()
        if half:
            return DeviceAnswerError(
                f"only half an answer to {question!r}{_before(stale, late)}",
                part=self.part,
                value=repr(half),
                limit=f"a whole line within {waited_s:g} s",
                todo=f"{self.another}, or check the cable and the baud rate",
            )
        return DeviceSilentError(
            f"no answer to {question!r}{_before(stale, late)}",
            part=self.part,
            limit=f"{waited_s:g} s",
            todo=f"check the cable and the power; {self.another}",
        )


def _before(stale: bytes, late: list[str]) -> str:
    if not stale and not late:
        return ""
    found = ([repr(stale)] if stale else []) + [repr(line) for line in late]
    return f", late answers {', '.join(found)} thrown away"
