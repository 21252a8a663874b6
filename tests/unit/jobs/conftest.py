"""Jobs with a clock that stands, and work that a test holds by the hand."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from datetime import UTC, datetime

import pytest

from rigctl.jobs import Job, Jobs, JobState, Task

START = datetime(2026, 1, 31, 12, 0, tzinfo=UTC)
BOUND_S = 60.0


class Clock:
    """A clock that a test sets."""

    def __init__(self) -> None:
        self.now = START

    def __call__(self) -> datetime:
        return self.now


class Held:
    """Work that says when it runs and ends when the test lets it, or when it is cancelled."""

    def __init__(self) -> None:
        self.runs = threading.Event()
        self._ends = threading.Event()

    def let_go(self) -> None:
        self._ends.set()

    def __call__(self, task: Task) -> str:
        task.on_cancel(self._ends.set)
        self.runs.set()
        assert self._ends.wait(BOUND_S)
        if task.cancelled:
            raise RuntimeError("let go because it was cancelled")
        return '{"answer": 42}'


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def jobs(clock: Clock) -> Iterator[Jobs]:
    opened = Jobs(at_a_time=1, most_waiting=2, most_kept=3, most_text=100, now=clock)
    yield opened
    opened.close()


@pytest.fixture
def held(jobs: Jobs) -> Iterator[Held]:
    work = Held()
    yield work
    work.let_go()


@pytest.fixture
def ended(jobs: Jobs) -> Callable[[Job], Job]:
    """Return a job as it ended."""

    def wait(job: Job) -> Job:
        last = jobs.wait(job.id, BOUND_S)
        assert last.state not in {JobState.QUEUED, JobState.RUNNING}, last
        return last

    return wait
