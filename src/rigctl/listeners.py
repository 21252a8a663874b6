"""Callbacks on changes."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")

_log = logging.getLogger(__name__)


class Listeners(Generic[T]):
    """Callbacks that are called with each change, in the thread that made it.

    A listener must return at once and may be called from any thread. An exception of a listener is
    logged, and the others are still called.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._callbacks: tuple[Callable[[T], None], ...] = ()

    def add(self, callback: Callable[[T], None]) -> Callable[[], None]:
        """Add a callback; calling what is returned removes it."""
        with self._lock:
            self._callbacks = (*self._callbacks, callback)

        def remove() -> None:
            with self._lock:
                self._callbacks = tuple(c for c in self._callbacks if c is not callback)

        return remove

    def notify(self, change: T) -> None:
        """Call every listener with the change."""
        for callback in self._callbacks:
            try:
                callback(change)
            except Exception:  # noqa: BLE001 - a listener is somebody else's code
                _log.exception("a listener failed")
