"""Signs of life for systemd: a unit of type `notify` with a watchdog; no effect elsewhere.

The protocol is that of sd_notify(3): datagrams to the socket that `NOTIFY_SOCKET` names.
"""

from __future__ import annotations

import contextlib
import os
import socket
import threading
from collections.abc import Callable

READY, STOPPING, ALIVE = "READY=1", "STOPPING=1", "WATCHDOG=1"


def notify(state: str) -> None:
    """Send a state to the service manager, if there is one. Never raises."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if address[:1] not in {"/", "@"}:
        return
    if address.startswith("@"):
        address = "\0" + address[1:]
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as link:
        link.connect(address)
        link.send(state.encode())


def watchdog_period_s() -> float | None:
    """Return how often a sign of life is due, s: a third of what the unit allows; None: never."""
    try:
        return int(os.environ["WATCHDOG_USEC"]) * 1e-6 / 3
    except (KeyError, ValueError):
        return None


class Watchdog:
    """Sends a sign of life while `alive` returns true, in a thread of its own.

    Parameters
    ----------
    alive
        Called before each sign; returns within a bound.
    """

    def __init__(self, alive: Callable[[], bool]) -> None:
        self._alive, self._ended = alive, threading.Event()
        self._period_s = watchdog_period_s()
        self._thread = threading.Thread(target=self._send, name="watchdog", daemon=True)
        if self._period_s is not None:
            self._thread.start()

    def close(self) -> None:
        """Send no more."""
        self._ended.set()

    def _send(self) -> None:
        while not self._ended.wait(self._period_s):
            if self._alive():
                notify(ALIVE)
