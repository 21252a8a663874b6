"""How long a job runs and how long it will: what its page says of a wait."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime

from rigctl.jobs.job import Job, JobState

TYPICAL_S = {
    "picture": 6.0,
    "explain": 40.0,
    "report": 20.0,
    "propose": 60.0,
    "next": 15.0,
    "export": 10.0,
}
"""Of kinds that no job has ended of since the start: of a hundred shots on a small computer, s."""
LATEST = 5
"""So many jobs of the kind say how long one takes."""
FIRM_SHARE = 0.5
"""From this share done on, what is done says more of the rest than other jobs do."""


@dataclass(frozen=True, slots=True)
class Wait:
    """How far a job is: seconds gone since it was asked, and left; None where nobody can say.

    `is_late` is whether it has taken longer than others of its kind.
    """

    gone_s: float
    left_s: float | None
    is_late: bool = False

    @property
    def share(self) -> float | None:
        """The part of the wait that is over, from 0 to 1."""
        if self.left_s is None:
            return None
        return self.gone_s / max(self.gone_s + self.left_s, 1e-9)


def wait_of(job: Job, others: Iterable[Job], now: datetime) -> Wait:
    """Return how long a job runs and will run.

    Parameters
    ----------
    others
        Jobs that are remembered, oldest first: those of its kind that are done say how long one
        takes.
    now
        The time, UTC.
    """
    gone = max(0.0, (now - job.created_at).total_seconds())
    ran = max(0.0, (now - (job.started_at or now)).total_seconds())
    usual = _usual_s(job.kind, others)
    if job.share is not None and job.share >= FIRM_SHARE:
        usual = ran / job.share
    if usual is None or ran > usual:
        return Wait(gone, None, is_late=usual is not None)
    return Wait(gone, max(1.0, usual - ran))


def _usual_s(kind: str, others: Iterable[Job]) -> float | None:
    took = [
        (other.ended_at - other.started_at).total_seconds()
        for other in others
        if other.kind == kind
        and other.state is JobState.DONE
        and other.started_at is not None
        and other.ended_at is not None
    ]
    return statistics.median(took[-LATEST:]) if took else TYPICAL_S.get(kind)
