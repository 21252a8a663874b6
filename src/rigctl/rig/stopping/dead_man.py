"""The dead man: a process of its own that cuts the power when the daemon dies or hangs.

`python -m rigctl.rig.stopping.dead_man PORT CHANNEL SILENT_S` is that process. It hears a heartbeat
on its standard input; where none comes in time, or the input ends, it opens the relay's port itself
and cuts.
"""

from __future__ import annotations

import contextlib
import logging
import os
import select
import signal
import subprocess
import sys
import termios
import threading
import time
import tty
from collections.abc import Callable
from typing import IO, cast

from rigctl.devices.lcus import BAUD, command
from rigctl.errors import DeviceError, DeviceSilentError

_log = logging.getLogger(__name__)

BEAT_S = 0.1
"""Time between two heartbeats, s."""

SILENT_S = 0.6
"""Longest silence before the power is cut, s."""

START_WITHIN_S = 20.0
"""Longest wait for the process to say that it watches, s."""

CUT_WITHIN_S = 30.0
"""So long the process goes on trying to cut where the port cannot be opened, s."""

CUT_BY_DEAD_MAN = "the dead man cut the power"
"""How the reason of a stop begins that the process has called for."""

_AGAIN_S = 0.02
_BEAT, _END, _READY = b".", b"e", b"r"


class DeadMan:
    """Watches over a daemon whose cut-off is an LCUS relay, which cannot watch by itself.

    Parameters
    ----------
    port, channel
        The relay: path of its serial port, and which contact carries the power.
    silent_s
        Longest silence before the power is cut, s.
    """

    def __init__(self, port: str, channel: int, silent_s: float = SILENT_S) -> None:
        self._port, self._channel, self._silent_s = port, channel, silent_s
        self._process: subprocess.Popen[bytes] | None = None
        self._ended = threading.Event()
        self._beating: threading.Thread | None = None

    @property
    def watches(self) -> bool:
        """Whether the process is there."""
        return self._process is not None and self._process.poll() is None

    def start(self, alive: Callable[[], bool], tripped: Callable[[str], None]) -> None:
        """Begin to watch, unless it does already; return once the process says so.

        Parameters
        ----------
        alive
            Asked before each heartbeat; one that is not answered with True is left out.
        tripped
            Told once, with the reason, when the process has ended although nobody ended it.

        Raises
        ------
        DeviceError
            The process cannot be started, or does not answer within `START_WITHIN_S`.
        """
        if self.watches:
            return
        self.end()
        self._ended.clear()
        process = self._spawn()
        self._process = process
        self._beating = threading.Thread(
            target=self._beat, args=(process, alive, tripped), name="heartbeat", daemon=True
        )
        self._beating.start()

    def end(self) -> None:
        """Watch no more. The caller has cut the power, or leaves it on deliberately."""
        self._ended.set()
        if self._beating is not None:
            self._beating.join(SILENT_S)
        process, self._process = self._process, None
        if process is None or process.stdin is None:
            return
        with contextlib.suppress(OSError), process.stdin:
            os.write(process.stdin.fileno(), _END)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(START_WITHIN_S)

    def _spawn(self) -> subprocess.Popen[bytes]:
        relay = [self._port, str(self._channel), str(self._silent_s)]
        words = [sys.executable, "-m", __name__, *relay]
        try:
            process = subprocess.Popen(  # noqa: S603 - our own module, on our own interpreter
                words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
            )
        except OSError as error:
            raise DeviceError(
                f"the process that cuts the power when the daemon dies cannot start: {error}",
                part="dead man",
                todo="look at the memory and the limits of this machine",
            ) from error
        with cast("IO[bytes]", process.stdout) as says:
            heard, _, _ = select.select([says], [], [], START_WITHIN_S)
            if not heard or os.read(says.fileno(), 1) != _READY:
                process.kill()
                process.wait()
                raise DeviceSilentError(
                    "the process that cuts the power when the daemon dies does not answer",
                    part="dead man",
                    limit=f"{START_WITHIN_S:g} s",
                    todo="look at the daemon's log, then release again",
                )
        return process

    def _beat(
        self,
        process: subprocess.Popen[bytes],
        alive: Callable[[], bool],
        tripped: Callable[[str], None],
    ) -> None:
        hears = cast("IO[bytes]", process.stdin)
        while not self._ended.wait(BEAT_S):
            if process.poll() is not None:
                tripped(f"{CUT_BY_DEAD_MAN}, or was ended by somebody else")
                return
            if alive():
                with contextlib.suppress(OSError):
                    os.write(hears.fileno(), _BEAT)


def cut(port: str, channel: int) -> bool:
    """Cut the power at the relay, past whoever holds its port; return whether the bytes left.

    The port is opened without its lock: a daemon that hangs still has it. Tries for
    `CUT_WITHIN_S`; a cut is harmless when repeated.
    """
    until = time.monotonic() + CUT_WITHIN_S
    while time.monotonic() < until:
        try:
            _write(port, command(channel, False))
        except OSError as error:
            _log.warning("%s: %s", port, error)
        except termios.error as error:
            _log.warning("%s: %s", port, error)
        else:
            return True
        time.sleep(_AGAIN_S)
    return False


def _write(port: str, data: bytes) -> None:
    line = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        tty.setraw(line, termios.TCSANOW)
        settings = termios.tcgetattr(line)
        settings[2] |= termios.CLOCAL
        settings[4] = settings[5] = getattr(termios, f"B{BAUD}")
        termios.tcsetattr(line, termios.TCSANOW, settings)
        if os.write(line, data) != len(data):
            raise BlockingIOError(f"{port} does not take {data!r}")
    finally:
        os.close(line)


def watch(port: str, channel: int, silent_s: float) -> int:
    """Watch until told to end, or until the heartbeat stops, and then cut; return the status."""
    # Whoever ends the daemon by a signal to all its processes must not end this one before it.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    os.write(sys.stdout.fileno(), _READY)
    while select.select([sys.stdin], [], [], silent_s)[0]:
        heard = os.read(sys.stdin.fileno(), 4096)
        if _END in heard:
            return 0
        if not heard:
            break
    _log.warning("no heartbeat from the daemon: the power is cut at %s", port)
    return 0 if cut(port, channel) else 1


if __name__ == "__main__":
    sys.exit(watch(sys.argv[1], int(sys.argv[2]), float(sys.argv[3])))
