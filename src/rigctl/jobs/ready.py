"""A process that has loaded what a job needs before one is asked: who waits is spared the loading.

At most one waits at a time; it has done nothing, knows no campaign, and serves one job as any.
"""

from __future__ import annotations

import threading
from contextlib import suppress

from rigctl.jobs.failure import JobFailedError
from rigctl.jobs.worker_process import WorkerProcess, conditions


class Ready:
    """Keeps a process ready that has loaded one module. Any thread may call any method."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._module = ""
        self._waiting: WorkerProcess | None = None
        self._closed = False

    @property
    def waiting(self) -> int | None:
        """Number of the process that waits; None: none does."""
        with self._lock:
            return None if self._waiting is None else self._waiting.pid

    def prepare(self, module: str) -> None:
        """Have a process ready for functions of a module from now on; returns at once."""
        with self._lock:
            known, self._module = self._module, module
        if known != module:
            self.refill_soon()

    def refill_soon(self) -> None:
        """Refill in a thread of its own: who cancels a job does not wait for the next process."""
        threading.Thread(target=self.refill, name="ready", daemon=True).start()

    def refill(self) -> None:
        """Start a process if none waits and one is wanted; without room for it there is none."""
        with self._lock, suppress(JobFailedError):
            if self._module and not self._closed and self._waiting is None:
                self._waiting = WorkerProcess(conditions(network=False, loads=(self._module,)))

    def take(self, module: str) -> WorkerProcess | None:
        """Return the process that waits, if it has this module and may be used as it was started.

        One that died meanwhile, or could read a file that is hidden by now, is not used.
        """
        with self._lock:
            waiting = self._waiting
            if waiting is None or waiting.under.loads != (module,):
                return None
            self._waiting = None
        if waiting.alive and waiting.under == conditions(network=False, loads=(module,)):
            return waiting
        waiting.close()
        return None

    def close(self) -> None:
        """End the process that waits; none is started again. Safe to call twice."""
        with self._lock:
            self._closed = True
            waiting, self._waiting = self._waiting, None
        if waiting is not None:
            waiting.close()


def started(ready: Ready | None, function: str, *, network: bool) -> WorkerProcess:
    """Return a process for a function `module:name`: the one that waits where it will do.

    Raises
    ------
    JobFailedError
        None can be started.
    """
    waiting = None
    if ready is not None and not network:
        waiting = ready.take(function.partition(":")[0])
    return waiting or WorkerProcess(conditions(network=network))
