"""A serial device behind a pseudo-terminal with a stable name."""

from __future__ import annotations

import contextlib
import heapq
import os
import select
import threading
import time
import tty
from collections.abc import Callable, Sequence
from pathlib import Path

from simulators.wire.faults import Answer

STOP_WITHIN_S = 5.0
READ_SIZE = 4096


class PtyPort:
    """Serves one device on a pseudo-terminal from a thread of its own.

    Parameters
    ----------
    receive
        Takes the host's bytes and returns the answers. Called from the port's thread only; what
        it raises ends the line, as a device that dies does.
    link
        Path of the symbolic link by which hosts open the port. It outlives reconnections, as
        a name under `/dev/serial/by-id` does.

    Notes
    -----
    A pseudo-terminal has no modem lines. The far end stays open here, so hosts may close and
    open the port at will and settings persist. Answers nobody reads are lost once the terminal's
    buffer is full, as on a line.
    """

    def __init__(self, receive: Callable[[bytes], Sequence[Answer]], link: Path) -> None:
        self._receive, self._link = receive, link
        self._lock = threading.Lock()
        self._line: _Line | None = None
        self.plug_in()

    @property
    def path(self) -> str:
        """The name under which hosts open the port."""
        return str(self._link)

    def plug_in(self) -> None:
        """Connect the device; harmless when it is connected."""
        with self._lock:
            if self._line is not None and self._line.alive:
                return
            self._drop()
            self._line = _Line(self._receive, self._link)

    def unplug(self) -> None:
        """Hang up and take the name away; harmless when nothing is connected."""
        with self._lock:
            self._drop()

    def close(self) -> None:
        """Unplug for good. Safe to call twice."""
        self.unplug()

    def _drop(self) -> None:
        if self._line is not None:
            self._line.close()
            self._line = None


class _Line:
    """One connection of the device, from plugging in to hanging up."""

    def __init__(self, receive: Callable[[bytes], Sequence[Answer]], link: Path) -> None:
        self._receive, self._link = receive, link
        self._late: list[tuple[float, int, bytes]] = []
        self._sent = 0
        self._ended = threading.Event()
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._wake_read, self._wake_write = os.pipe()
        if link.is_symlink():
            link.unlink()
        self._terminal = os.ttyname(self._slave)
        link.symlink_to(self._terminal)
        self._thread = threading.Thread(target=self._serve, name=f"port {link.name}", daemon=True)
        self._thread.start()

    @property
    def alive(self) -> bool:
        return not self._ended.is_set()

    def close(self) -> None:
        with contextlib.suppress(BrokenPipeError):
            os.write(self._wake_write, b"x")
        self._thread.join(STOP_WITHIN_S)
        if self._thread.is_alive():
            raise RuntimeError(
                f"port {self._link.name}: its device did not return within {STOP_WITHIN_S} s"
            )
        os.close(self._wake_write)

    def _serve(self) -> None:
        try:
            while self._turn():
                pass
        finally:
            # Before the host can notice: who plugs in again then must not find the line alive.
            self._ended.set()
            self._take_name_away()
            for descriptor in (self._master, self._slave, self._wake_read):
                os.close(descriptor)

    def _take_name_away(self) -> None:
        # Another laboratory in the same folder may have taken the name over.
        with contextlib.suppress(OSError):
            if os.readlink(self._link) == self._terminal:
                self._link.unlink()

    def _turn(self) -> bool:
        """Wait for bytes, for a late answer's time or for the end; False ends the line."""
        wait = max(0.0, self._late[0][0] - time.monotonic()) if self._late else None
        ready, _, _ = select.select([self._master, self._wake_read], [], [], wait)
        if self._wake_read in ready:
            return False
        if self._master in ready:
            for answer in self._receive(os.read(self._master, READ_SIZE)):
                if answer.hang_up:
                    return False
                self._schedule(answer)
        while self._late and self._late[0][0] <= time.monotonic():
            self._write(heapq.heappop(self._late)[2])
        return True

    def _schedule(self, answer: Answer) -> None:
        if answer.after_s == 0:
            self._write(answer.data)
            return
        self._sent += 1
        due = time.monotonic() + answer.after_s
        heapq.heappush(self._late, (due, self._sent, answer.data))

    def _write(self, data: bytes) -> None:
        with contextlib.suppress(BlockingIOError):
            os.write(self._master, data)
