"""What a piece of long work is, and the thread in which a job speaks and hears."""

from __future__ import annotations

import threading
from collections.abc import Callable

from rigctl.errors import RigError
from rigctl.progress import Progress


class JobFailedError(RigError):
    """Long work broke, took too long, or its process died.

    Parameters
    ----------
    what, limit, todo
        As every error of the tree.
    because
        The stable code of the error that the work itself raised, where it has one.
    """

    code = "job-failed"

    def __init__(
        self,
        what: str,
        *,
        limit: str | None = None,
        todo: str | None = None,
        because: str | None = None,
    ) -> None:
        self.because = because or self.code
        super().__init__(what, limit=limit, todo=todo)


class Task:
    """A running job as its work sees it: it says how far it is, and hears when it is not wanted.

    Any thread may call any of its methods.

    Parameters
    ----------
    progress
        Takes the step under way in words and the share done from 0 to 1, or None.
    enclosed
        Takes in words what the process of the work is kept from.
    """

    def __init__(
        self,
        progress: Progress,
        enclosed: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.progress, self.enclosed = progress, enclosed
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

    def cancel(self) -> None:
        """Say that the work is not wanted any more. Safe to call twice."""
        with self._lock:
            self._unwanted = True
            callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            callback()


Work = Callable[[Task], str]
"""Long work: it returns a JSON object as text, raises `RigError` with the reason, and ends soon
after it is cancelled."""
