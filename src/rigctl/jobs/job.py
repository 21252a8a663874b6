"""One piece of long work as an unchangeable snapshot."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum


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
    """A job at one moment. Times are UTC.

    Attributes
    ----------
    id
        16 hexadecimal digits, by chance: a name is never given twice, not even after a restart.
    kind, subject
        What is done, and to which campaign.
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
    enclosure: str = ""
    progress: str = ""
    share: float | None = None
    result: str | None = None
    failure: str | None = None
    failure_code: str | None = None
