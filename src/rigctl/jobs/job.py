"""One piece of long work as an unchangeable snapshot, and the register of all."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from enum import StrEnum
from typing import Any

from rigctl.errors import JobsFullError, NotFoundError
from rigctl.listeners import Listeners


class JobState(StrEnum):
    """Where a job stands.

    ::

        queued --> running --> done, failed
           |          |
           +----------+------> cancelled
    """

    QUEUED = "queued"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


ENDED = frozenset({JobState.DONE, JobState.FAILED, JobState.CANCELLED})
"""States that a job never leaves."""


@dataclass(frozen=True, slots=True)
class Job:
    """A job at one moment. Times are those of `utc_now`.

    Attributes
    ----------
    id
        16 hexadecimal digits, by chance: a name is never given twice, not even after a restart.
    kind, subject
        What is done, and to which campaign.
    folder
        Where the shots lie that were asked; empty: in the store, under the campaign's name. Folders
        of any laboratory may bear a name that a campaign of the store has.
    enclosure
        What the process of its work is kept from, in words; empty until it runs in one.
    progress, share
        The step under way in words, and the part done from 0 to 1, None where nobody can say.
    result
        JSON text of an object once the job is `done`. It is never parsed on its way to whoever
        asked: a large one would hold up every thread of the daemon, those that fire among them.
    failure, failure_code
        Why it is `failed`, in one sentence, with the error's stable code.
    """

    id: str
    kind: str
    subject: str
    state: JobState
    created_at: datetime
    started_at: datetime | None = None
    ended_at: datetime | None = None
    folder: str = ""
    enclosure: str = ""
    progress: str = ""
    share: float | None = None
    result: str | None = None
    failure: str | None = None
    failure_code: str | None = None


LIVE = frozenset({JobState.QUEUED, JobState.RUNNING})


_BEGAN = (datetime.now(UTC), time.monotonic())


def utc_now() -> datetime:
    """Return the time, UTC, counted from the program's start by the monotonic clock.

    Where the host's clock is set meanwhile, waits stay as long as they are and no result is
    forgotten early.
    """
    at, monotonic_s = _BEGAN
    return at + timedelta(seconds=time.monotonic() - monotonic_s)


class Register:
    """Table of jobs. Any thread may call any method; `listeners` are called at every change.

    Parameters
    ----------
    most_waiting, most_kept
        How many may be queued, and how many that have ended are remembered.
    most_text
        Characters that their results may have together; the job that ended last is kept anyway.
    kept_for
        How long an ended job is remembered at most.
    now
        The clock, UTC.
    """

    def __init__(
        self,
        *,
        most_waiting: int,
        most_kept: int,
        most_text: int,
        kept_for: timedelta,
        now: Callable[[], datetime],
    ) -> None:
        self.listeners: Listeners[Job] = Listeners()
        self._most_waiting, self._most_kept, self._most_text = most_waiting, most_kept, most_text
        self._kept_for = kept_for
        self._now = now
        self._changed = threading.Condition()
        self._jobs: dict[str, Job] = {}
        self._asked: dict[Hashable, str] = {}

    def add(self, kind: str, subject: str, key: Hashable, folder: str = "") -> tuple[Job, bool]:
        """Return a queued job, or the one that answers `key`, and whether it was there before.

        Raises
        ------
        JobsFullError
            Too many are queued already.
        """
        with self._changed:
            self._forget()
            same = self._jobs.get(self._asked.get(key, "")) if key is not None else None
            if same is not None and same.state not in {JobState.FAILED, JobState.CANCELLED}:
                return same, True
            self._require_room()
            job = Job(
                secrets.token_hex(8), kind, subject, JobState.QUEUED, self._now(), folder=folder
            )
            self._jobs[job.id] = job
            if key is not None:
                self._asked[key] = job.id
        self.listeners.notify(job)
        return job, False

    def change(self, job: str, of: frozenset[JobState], **changes: Any) -> bool:  # noqa: ANN401
        """Change fields of a job that stands in one of these states; say whether it did."""
        with self._changed:
            present = self._jobs.get(job)
            if present is None or present.state not in of:
                return False
            changed = self._jobs[job] = replace(present, **changes)
            self._changed.notify_all()
        self.listeners.notify(changed)
        return True

    def start(self, job: str) -> bool:
        """Let a queued job run; say whether it was queued still."""
        queued = frozenset({JobState.QUEUED})
        return self.change(job, queued, state=JobState.RUNNING, started_at=self._now())

    def end(self, job: str, state: JobState, of: frozenset[JobState] = LIVE, **known: Any) -> bool:  # noqa: ANN401
        """Give a job its last state with what is known of it; say whether it had none yet."""
        return self.change(job, of, state=state, ended_at=self._now(), **known)

    def progress(self, job: str, text: str, share: float | None) -> None:
        """Note how far a running job is."""
        self.change(job, frozenset({JobState.RUNNING}), progress=text, share=share)

    def enclosed(self, job: str, enclosure: str) -> None:
        """Note what a running job's process is kept from."""
        self.change(job, frozenset({JobState.RUNNING}), enclosure=enclosure)

    def job(self, name: str) -> Job:
        """Return a job; raise `NotFoundError` where none of that name is remembered."""
        with self._changed:
            self._forget()
            found = self._jobs.get(name)
        if found is None:
            raise NotFoundError("no such job", value=repr(name), todo="list the jobs, or ask again")
        return found

    def jobs(self) -> list[Job]:
        """Return all jobs that are remembered, oldest first."""
        with self._changed:
            self._forget()
            return list(self._jobs.values())

    def wait(self, name: str, timeout_s: float) -> Job:
        """Return a job when it has ended, or as it stands when the time is over."""
        with self._changed:
            self._changed.wait_for(lambda: self.job(name).state in ENDED, timeout_s)
            return self.job(name)

    def _require_room(self) -> None:
        waiting = sum(job.state is JobState.QUEUED for job in self._jobs.values())
        if waiting >= self._most_waiting:
            raise JobsFullError(
                "no further job is taken",
                value=f"{waiting} waiting",
                limit=f"{self._most_waiting}",
                todo="wait until one has ended, or cancel one",
            )

    def _forget(self) -> None:
        oldest = self._now() - self._kept_for
        ended = [(job.ended_at, job) for job in self._jobs.values() if job.ended_at is not None]
        ended.sort(key=lambda pair: pair[0])
        text = 0
        for k, (at, job) in enumerate(reversed(ended)):
            text += len(job.result or "")
            if k >= self._most_kept or at < oldest or (k > 0 and text > self._most_text):
                del self._jobs[job.id]
        self._asked = {key: name for key, name in self._asked.items() if name in self._jobs}
