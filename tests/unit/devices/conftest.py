"""A device behind a pseudo-terminal that does exactly what a test tells it."""

from __future__ import annotations

import os
import select
import threading
import tty
from collections.abc import Callable, Iterator
from types import SimpleNamespace

import pytest

Answer = Callable[[bytes], bytes]


class PtyDevice:
    """Hands each message that the host writes to `answer` and writes back what it returns.

    A message ends with `terminator`, or holds `length` bytes where a protocol has no lines.
    """

    def __init__(
        self, answer: Answer, terminator: bytes = b"\n", length: int | None = None
    ) -> None:
        self.answer, self.terminator, self.length = answer, terminator, length
        self.messages: list[bytes] = []
        self._arrived = threading.Condition()
        self._master, slave = os.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        self._slave = slave
        self._stop_read, self._stop_write = os.pipe()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def write(self, data: bytes) -> None:
        """Say something unasked."""
        os.write(self._master, data)

    def hang_up(self) -> None:
        """Pull the cable."""
        self._end_thread()
        os.close(self._slave)
        os.close(self._master)
        self._master = self._slave = -1

    def wait_for(self, count: int) -> list[bytes]:
        """Return the messages once `count` have come; fail after a minute."""
        with self._arrived:
            assert self._arrived.wait_for(lambda: len(self.messages) >= count, timeout=60.0)
            return list(self.messages)

    def close(self) -> None:
        if self._master >= 0:
            self.hang_up()
        os.close(self._stop_read)

    def _end_thread(self) -> None:
        os.close(self._stop_write)
        self._thread.join(timeout=60.0)
        assert not self._thread.is_alive()

    def _serve(self) -> None:
        pending = b""
        while True:
            ready, _, _ = select.select([self._master, self._stop_read], [], [])
            if self._stop_read in ready:
                return
            pending += os.read(self._master, 4096)
            while (size := self._message_size(pending)) > 0:
                message, pending = pending[:size], pending[size:]
                reply = self.answer(message)
                with self._arrived:
                    self.messages.append(message)
                    self._arrived.notify_all()
                if reply:
                    os.write(self._master, reply)

    def _message_size(self, pending: bytes) -> int:
        if self.length is not None:
            return self.length if len(pending) >= self.length else 0
        return (
            pending.find(self.terminator) + len(self.terminator)
            if self.terminator in pending
            else 0
        )


class Looks:
    """Time that passes by looks at it alone: a port waits for a number of its slices of reading.

    A machine that is busy between two slices costs no answer.
    """

    LOOK_S = 0.01

    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        self.now_s += self.LOOK_S
        return self.now_s


@pytest.fixture(autouse=True)
def looks(monkeypatch: pytest.MonkeyPatch) -> Looks:
    """The clock of all serial ports of a test."""
    clock = Looks()
    monkeypatch.setattr("rigctl.devices.serial_port.time", SimpleNamespace(monotonic=clock))
    return clock


@pytest.fixture
def pty_device() -> Iterator[Callable[..., PtyDevice]]:
    """A factory of devices behind pseudo-terminals, all ended with the test."""
    devices: list[PtyDevice] = []

    def build(answer: Answer = lambda message: b"", **options: object) -> PtyDevice:
        devices.append(PtyDevice(answer, **options))  # type: ignore[arg-type]
        return devices[-1]

    yield build
    for device in devices:
        device.close()
