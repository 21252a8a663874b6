"""The status of work that goes on in a thread of its own."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from bluesky.protocols import Status

_log = logging.getLogger(__name__)


class WorkStatus(Status):
    """Done when the work has ended, successful when it raised nothing.

    Parameters
    ----------
    name
        Of the work, for those who look at a status that lasts.
    work
        Bounds its own waits; it is not interrupted.
    """

    def __init__(self, name: str, work: Callable[[], None]) -> None:
        self.name = name
        self._work = work
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._failure: BaseException | None = None
        self._callbacks: list[Callable[[Status], None]] = []
        threading.Thread(target=self._run, name=name, daemon=True).start()

    def __repr__(self) -> str:
        state = "running" if not self.done else "done" if self.success else repr(self._failure)
        return f"<{self.name}: {state}>"

    def add_callback(self, callback: Callable[[Status], None]) -> None:
        """Call this when the work has ended; at once, if it has."""
        with self._lock:
            if not self._ended.is_set():
                self._callbacks.append(callback)
                return
        callback(self)

    def exception(self, timeout: float | None = 0.0) -> BaseException | None:
        """Return what the work raised, waiting at most `timeout` seconds for its end.

        Raises
        ------
        TimeoutError
            It has not ended.
        """
        if not self._ended.wait(timeout):
            raise TimeoutError(f"{self.name} has not ended")
        return self._failure

    @property
    def done(self) -> bool:
        """Whether the work has ended."""
        return self._ended.is_set()

    @property
    def success(self) -> bool:
        """Whether it has ended well."""
        return self.done and self._failure is None

    def _run(self) -> None:
        try:
            self._work()
        except Exception as error:  # noqa: BLE001 - whoever waits is told of any failure
            self._failure = error
        with self._lock:
            self._ended.set()
            callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            try:
                callback(self)
            except Exception:  # noqa: BLE001 - whatever the others' callbacks raise
                # Such as that of an engine which was closed meanwhile; the others are called.
                _log.exception("%s has ended, and a callback of it failed", self.name)
