"""What a piece of long work is, and how it reports progress and is cancelled."""

from __future__ import annotations

import threading
from collections.abc import Callable

from rigctl.jobs.failure import JobFailedError
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
        self.enclosed, self.ready = enclosed, ready
        self._progress = progress
        self._lock = threading.Lock()
        self._unwanted = False
        self._callbacks: list[Callable[[], None]] = []

    def progress(self, text: str, share: float | None) -> None:
        """Say the step under way in words and the share done, from 0 to 1, or None.

        Raises
        ------
        JobFailedError
            The work was cancelled: it ends here.
        """
        if self.cancelled:
            raise JobFailedError("cancelled")
        self._progress(text, share)

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
        """Have the work end; return whether callbacks of it were called. Twice is safe.

        Its callbacks end it at once. Work that has left none ends when it next calls `progress`
        or `on_cancel`; if it calls neither, when it is done.
        """
        with self._lock:
            self._unwanted = True
            callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            callback()
        return bool(callbacks)


Work = Callable[[Task], str]
"""Long work: it returns a JSON object as text, raises `RigError` with the reason, and ends as
`Task.cancel` has it."""
