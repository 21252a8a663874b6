"""What happened last, kept for pages that open later."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, TypeVar

from rigctl.daemon import Daemon
from rigctl.jobs import Job
from rigctl.rig.status import Transition
from rigctl.store import ShotRecord
from rigctl.sweeps.status import SweepStatus

T = TypeVar("T")
MOST_KEPT = 200
READ_BACK = 30
"""So many entries of the audit are shown from before the start."""

JOBS = {
    "picture": "comparing the model with",
    "explain": "finding what is missing in",
    "path": "following a shot of",
    "next": "choosing next shots of",
    "propose": "looking for a law of",
}
"""What a job does, where its kind as REST names it does not say it."""


@dataclass(frozen=True, slots=True)
class Happening:
    """One thing that happened: its number, when (UTC), what kind of thing, and what, in words."""

    number: int
    at: datetime
    kind: str
    text: str


class Feed:
    """The last happenings of rig, shots, sweeps and jobs. Any thread may read it.

    `told` is another number after each change of any of them or of a campaign, also where there is
    nothing to say: who has seen it need not look again.
    """

    def __init__(self, daemon: Daemon) -> None:
        self._kept: deque[Happening] = deque(maxlen=MOST_KEPT)
        self._numbers = itertools.count(1)
        self._said: dict[str, str] = {}
        self._told = itertools.count(1)
        self._shared: dict[str, tuple[int, Any]] = {}
        self.told = 0
        self._read_back(daemon)
        daemon.rig.listeners.add(self._rig)
        daemon.store.listeners.add(self._shot)
        daemon.store.campaign_listeners.add(lambda _: self._tell())
        daemon.sweeps.listeners.add(self._sweep)
        daemon.jobs.listeners.add(self._job)

    def latest(self, count: int) -> list[Happening]:
        """Return the last happenings, the latest first."""
        return list(itertools.islice(reversed(tuple(self._kept)), count))

    def shared(self, name: str, read: Callable[[], T]) -> T:
        """Return what `read` finds in the store; read once after each change for all pages."""
        told, found = self.told, self._shared.get(name)
        if found is None or found[0] != told:
            found = self._shared[name] = told, read()
        value: T = found[1]
        return value

    @property
    def last(self) -> int:
        """Number of the latest happening, 0 before the first."""
        kept = tuple(self._kept)
        return kept[-1].number if kept else 0

    def _read_back(self, daemon: Daemon) -> None:
        last = daemon.store.journal.last()
        if last is not None:
            for entry in daemon.store.journal.entries(after=last.number - READ_BACK):
                self._keep("rig", f"{entry.after}: {entry.reason}", entry.at)

    def _rig(self, step: Transition) -> None:
        self._tell()
        text = f"{step.after}: {step.reason}" if step.reason else str(step.after)
        self._keep("rig", text, step.at)

    def _shot(self, shot: ShotRecord) -> None:
        self._tell()
        why = f": {shot.failure}" if shot.failure else ""
        self._keep("shot", f"shot {shot.number} {shot.state}{why}")

    def _sweep(self, status: SweepStatus) -> None:
        self._tell()
        record = status.record
        self._once(f"sweep {record.id}", "sweep", f"sweep {record.id} {record.state}")

    def _job(self, job: Job) -> None:
        self._tell()
        why = f": {job.failure}" if job.failure else ""
        what = JOBS.get(job.kind, f"{job.kind} of")
        self._once(f"job {job.id}", "job", f"{what} {job.subject}: {job.state}{why}")

    def _tell(self) -> None:
        self.told = next(self._told)

    def _once(self, subject: str, kind: str, text: str) -> None:
        """Keep what is said of a subject, unless it was the last thing said of it."""
        if self._said.get(subject) != text:
            self._said[subject] = text
            self._keep(kind, text)

    def _keep(self, kind: str, text: str, at: datetime | None = None) -> None:
        self._kept.append(Happening(next(self._numbers), at or datetime.now(UTC), kind, text))
