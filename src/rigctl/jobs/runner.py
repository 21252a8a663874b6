"""Threads that run jobs: a bounded number at a time, and a cancellation waits within a bound."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Hashable
from datetime import datetime, timedelta
from queue import SimpleQueue

from rigctl.errors import JobsFullError, RigError
from rigctl.jobs.failure import JobFailedError
from rigctl.jobs.job import LIVE, Job, JobState, Register, utc_now
from rigctl.jobs.ready import Ready
from rigctl.jobs.task import Task, Work
from rigctl.listeners import Listeners

_log = logging.getLogger(__name__)

AT_A_TIME = 2
MOST_WAITING = 16
MOST_KEPT = 100
MOST_TEXT = 64 * 1024**2
KEPT_FOR = timedelta(hours=24)
END_WAIT_S = 5.0

QUEUED = frozenset({JobState.QUEUED})


class Jobs:
    """Runs work in threads of its own and remembers what became of it.

    Any thread may call any method. The jobs that ended last are remembered, at most 100 of them,
    with at most 64 MiB of results, for at most a day; the end of the daemon forgets them all.

    Parameters
    ----------
    at_a_time, most_waiting, most_kept
        How many run, how many more may wait, and how many that have ended are remembered.
    most_text
        Characters that the remembered results may have together.
    now
        The clock, UTC.
    """

    def __init__(
        self,
        *,
        at_a_time: int = AT_A_TIME,
        most_waiting: int = MOST_WAITING,
        most_kept: int = MOST_KEPT,
        most_text: int = MOST_TEXT,
        now: Callable[[], datetime] = utc_now,
    ) -> None:
        self._register = Register(
            most_waiting=most_waiting,
            most_kept=most_kept,
            most_text=most_text,
            kept_for=KEPT_FOR,
            now=now,
        )
        self._ready = Ready()
        self._lock = threading.Lock()
        self._tasks: dict[str, Task] = {}
        self._closed = False
        self._waiting: SimpleQueue[tuple[str, Work] | None] = SimpleQueue()
        self._threads = [
            threading.Thread(target=self._serve, name="job", daemon=True) for _ in range(at_a_time)
        ]
        for thread in self._threads:
            thread.start()

    @property
    def listeners(self) -> Listeners[Job]:
        """Callbacks, called at every change of a job."""
        return self._register.listeners

    def prepare(self, module: str) -> None:
        """Have a process load a module that further jobs will need; returns at once."""
        self._ready.prepare(module)

    def submit(
        self, kind: str, subject: str, work: Work, key: Hashable = None, *, folder: str = ""
    ) -> Job:
        """Queue work and return its job.

        Parameters
        ----------
        kind, subject
            What is done, and to which campaign.
        work
            Called in a thread of its own when its turn comes.
        key
            Names the question. A job of the same key that has neither failed nor been cancelled
            is returned in the place of another one; None: always another one.
        folder
            Where the shots lie; empty: in the store.

        Raises
        ------
        JobsFullError
            Too many jobs wait already, or the daemon ends.
        """
        with self._lock:
            if self._closed:
                raise JobsFullError("no further job is taken", todo="start the daemon again")
            job, known = self._register.add(kind, subject, key, folder)
            if not known:
                register = self._register
                self._tasks[job.id] = Task(
                    lambda text, share: register.progress(job.id, text, share),
                    lambda words: register.enclosed(job.id, words),
                    self._ready,
                )
                self._waiting.put((job.id, work))
        return job

    def job(self, name: str) -> Job:
        """Return a job; raise `NotFoundError` where none of that name is remembered."""
        return self._register.job(name)

    def jobs(self) -> list[Job]:
        """Return all jobs that are remembered, oldest first."""
        return self._register.jobs()

    def wait(self, name: str, timeout_s: float) -> Job:
        """Return a job when it has ended, or as it stands when the time is over."""
        return self._register.wait(name, timeout_s)

    def cancel(self, name: str) -> Job:
        """End a job and return it; one that has ended is left as it is.

        Waits at most 5 s for the end of work that is under way.

        Raises
        ------
        NotFoundError
            No job of that name is remembered.
        """
        self._register.job(name)
        self._cancel(name)
        return self._register.wait(name, END_WAIT_S)

    def close(self) -> None:
        """Cancel every job and end the threads, within a bound. Safe to call twice."""
        with self._lock:
            self._closed = True
        for job in self._register.jobs():
            if job.state in LIVE:
                self._cancel(job.id)
        for _ in self._threads:
            self._waiting.put(None)
        for thread in self._threads:
            thread.join(END_WAIT_S)
        self._ready.close()

    def _cancel(self, name: str) -> None:
        with self._lock:
            task = self._tasks.get(name)
        if self._register.end(name, JobState.CANCELLED, of=QUEUED) or task is None:
            return
        if task.cancel():
            # Its work ends: who waits for the job need not wait until it has cleared up.
            self._register.end(name, JobState.CANCELLED)

    def _serve(self) -> None:
        while (item := self._waiting.get()) is not None:
            name, work = item
            task = self._tasks[name]
            try:
                if self._register.start(name):
                    self._run(name, work, task)
            finally:
                with self._lock:
                    del self._tasks[name]

    def _run(self, name: str, work: Work, task: Task) -> None:
        try:
            result = work(task)
        except JobFailedError as error:
            self._fail(name, task, error.sentence(), error.because)
        except RigError as error:
            self._fail(name, task, error.sentence(), error.code)
        except Exception as error:  # noqa: BLE001 - whatever breaks is this job's failure alone
            _log.exception("job %s broke", name)
            self._fail(name, task, repr(error), JobFailedError.code)
        else:
            self._register.end(name, JobState.DONE, result=result, share=1.0)

    def _fail(self, name: str, task: Task, failure: str, code: str) -> None:
        if task.cancelled:
            self._register.end(name, JobState.CANCELLED)
        else:
            self._register.end(name, JobState.FAILED, failure=failure, failure_code=code)
