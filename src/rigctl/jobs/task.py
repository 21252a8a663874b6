"""What a piece of long work is, and how it reports progress and is cancelled."""

from __future__ import annotations

import threading
from collections.abc import Callable

from rigctl.jobs.ready import Ready
from rigctl.progress import Progress


class Task:
    """A running job as its work sees it: it takes progress, and passes on a cancellation.

    Any thread may call any of its methods.

    Parameters
    ----------
    progress
        Takes the step under way in words and the share done from 0 to 1, or None.
    enclosed
        Takes in words what the process of the work is kept from.
    ready
        Where a process may wait for the work already.
    """

    def __init__(
        self,
        progress: Progress,
        enclosed: Callable[[str], None] = lambda _: None,
        ready: Ready | None = None,
    ) -> None:
        self.progress, self.enclosed, self.ready = progress, enclosed, ready
        self._lock = threading.Lock()
        self._unwanted = False
        self._callbacks: list[Callable[[], None]] = []

    @property
    def cancelled(self) -> bool:
        """Whether the work is no longer wanted."""
        with self._lock:
            return self._unwanted

    def on_cancel(self, callback: Callable[[], None]) -> None:
        """Have a callback called once when the work is cancelled; at once if it has been."""
        with self._lock:
            if not self._unwanted:
                self._callbacks.append(callback)
                return
        callback()

    def cancel(self) -> bool:
        """Say that the work is not wanted any more; return whether that ends it. Twice is safe.

        What has left a callback is ended by it; other work looks by itself, sooner or later.
        """
        with self._lock:
            self._unwanted = True
            callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            callback()
        return bool(callbacks)


Work = Callable[[Task], str]
"""Long work: it returns a JSON object as text, raises `RigError` with the reason, and ends soon
after it is cancelled."""
