"""Orders to a running sweep, and waits that end when one is given."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum


class Wish(StrEnum):
    """Order to a running sweep; it takes effect before the next fire."""

    PAUSE = "pause"
    ABORT = "abort"


@dataclass(frozen=True, slots=True)
class Order:
    """A wish, with the words for the sweep's reason."""

    wish: Wish
    reason: str


class Orders:
    """The latest order to one sweep; any thread may call any method.

    Parameters
    ----------
    idle
        Waits for an event, at most so many seconds.
    """

    def __init__(self, idle: Callable[[threading.Event, float], object]) -> None:
        self._idle = idle
        self._given = threading.Event()
        self._lock = threading.Lock()
        self._order: Order | None = None

    @property
    def order(self) -> Order | None:
        """The order that is to be followed, or None."""
        with self._lock:
            return self._order

    def give(self, order: Order) -> None:
        """Give an order; after an abort nothing else counts."""
        with self._lock:
            if self._order is None or self._order.wish is not Wish.ABORT:
                self._order = order
        self._given.set()

    def wait(self, seconds: float) -> None:
        """Wait so long, or until there is an order."""
        if seconds > 0.0 and not self._given.is_set():
            self._idle(self._given, seconds)
