"""A process that has loaded what a job needs before the job is asked for."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from rigctl.jobs import Jobs, JobState, Task, in_process
from rigctl.jobs.ready import Ready
from rigctl.jobs.worker_process import hide_from_jobs

BOUND_S = 60.0
STAND_IN = "stand_in_work"


@pytest.fixture(autouse=True)
def stand_in(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    monkeypatch.syspath_prepend(request.path.parent)


@pytest.fixture
def ready() -> Iterator[Ready]:
    found = Ready()
    yield found
    found.close()


def wanted(ready: Ready, module: str) -> None:
    """Have a process wait, started in this thread: nothing is left to chance."""
    ready.prepare(module)
    ready.refill()


def answered_by(ready: Ready) -> int:
    """Return the number of the process that answers a job."""
    work = in_process(f"{STAND_IN}:answers", {}, BOUND_S)
    return int(json.loads(work(Task(lambda _text, _share: None, ready=ready)))["process"])


def test_a_job_is_done_by_the_process_that_waited_and_another_waits_afterwards(
    ready: Ready,
) -> None:
    wanted(ready, STAND_IN)
    waited = ready.waiting
    assert answered_by(ready) == waited
    ready.refill()
    assert ready.waiting not in {None, waited, os.getpid()}


def test_each_job_has_a_process_of_its_own(ready: Ready) -> None:
    wanted(ready, STAND_IN)
    first = answered_by(ready)
    ready.refill()
    assert answered_by(ready) != first


def test_a_job_of_another_module_leaves_the_process_to_those_it_waits_for(ready: Ready) -> None:
    wanted(ready, "json")
    waits = ready.waiting
    assert answered_by(ready) != waits
    assert ready.waiting == waits


def test_a_process_that_could_read_what_is_hidden_since_is_not_used(
    ready: Ready, tmp_path: Path
) -> None:
    wanted(ready, STAND_IN)
    hide_from_jobs(tmp_path / "service.json")
    assert ready.take(STAND_IN) is None


def test_a_process_that_died_while_it_waited_is_not_used(ready: Ready) -> None:
    wanted(ready, STAND_IN)
    waiting = ready.take(STAND_IN)
    assert waiting is not None
    waiting.close()
    assert not waiting.alive
    assert answered_by(ready) != waiting.pid


def test_what_cannot_be_loaded_fails_the_job_and_not_the_daemon() -> None:
    jobs = Jobs()
    jobs.prepare("no_such_module")
    work = in_process("no_such_module:answers", {}, BOUND_S)
    job = jobs.wait(jobs.submit("fits", "nylon", work).id, BOUND_S)
    jobs.close()
    assert job.state is JobState.FAILED
    assert "no_such_module" in (job.failure or "")


def test_nothing_waits_any_more_when_the_daemon_has_ended(ready: Ready) -> None:
    wanted(ready, STAND_IN)
    ready.close()
    ready.refill()
    assert ready.take(STAND_IN) is None
