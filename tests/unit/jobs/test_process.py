from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from rigctl.jobs import JobFailedError, Jobs, JobState, Task, in_process
from rigctl.jobs.worker_process import NICENESS

BOUND_S = 60.0


@pytest.fixture(autouse=True)
def stand_in(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    monkeypatch.syspath_prepend(request.path.parent)


class Heard:
    """A task whose words are kept; a test can wait for the first."""

    def __init__(self) -> None:
        self.words: list[tuple[str, float | None]] = []
        self.spoke = threading.Event()
        self.task = Task(self._say)

    def _say(self, text: str, share: float | None) -> None:
        self.words.append((text, share))
        self.spoke.set()


def run(function: str, heard: Heard | None = None, longest_s: float = BOUND_S) -> dict[str, Any]:
    work = in_process(f"stand_in_work:{function}", {"with": ["drag"]}, longest_s)
    return json.loads(work((heard or Heard()).task))


def test_the_work_is_done_in_another_process_and_says_how_far_it_is() -> None:
    heard = Heard()
    answer = run("answers", heard)
    assert answer["asked"] == {"with": ["drag"]}
    assert answer["process"] != os.getpid()
    assert heard.words == [("half way", 0.5)]


def test_the_process_gives_way_to_the_daemon_and_takes_one_processor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    assert run("conditions") == {"nice": min(19, os.nice(0) + NICENESS), "threads": "1"}


@pytest.mark.parametrize(
    ("function", "words", "code"),
    [
        ("refuses", "result-0001.json: holds no poses; analyse it again", "analysis-input"),
        ("breaks", "ValueError: a bug", "job-failed"),
        ("not_finite", "ValueError: Out of range float values", "job-failed"),
        ("absent", "AttributeError: module 'stand_in_work'", "job-failed"),
        ("crashes", "the process was killed by SIGSEGV", "job-failed"),
        ("leaves", "the process ended with status 3", "job-failed"),
    ],
)
def test_work_that_brings_no_result_says_why(function: str, words: str, code: str) -> None:
    with pytest.raises(JobFailedError) as found:
        run(function)
    assert words in str(found.value)
    assert found.value.because == code


def test_work_beyond_its_time_is_killed() -> None:
    heard = Heard()
    # A busy machine takes longer than the first of these to start a process at all.
    for longest_s in (3.0, 15.0, 75.0):
        with pytest.raises(JobFailedError, match=rf"took too long \(limit {longest_s:g} s\)"):
            run("never_ends", heard, longest_s=longest_s)
        if heard.words:
            break
    assert is_gone(int(heard.words[0][0]))


@pytest.fixture
def running() -> Iterator[tuple[Jobs, str, int]]:
    """Give jobs with one that never ends by itself, its name and its process."""
    jobs, spoke, words = Jobs(), threading.Event(), list[str]()

    def hear(job: Any) -> None:
        if job.progress:
            words.append(job.progress)
            spoke.set()

    jobs.listeners.add(hear)
    job = jobs.submit("fits", "nylon", in_process("stand_in_work:never_ends", {}))
    assert spoke.wait(BOUND_S)
    yield jobs, job.id, int(words[0])
    jobs.close()


def test_cancelling_kills_the_process(running: tuple[Jobs, str, int]) -> None:
    jobs, name, process = running
    assert jobs.cancel(name).state is JobState.CANCELLED
    jobs.close()
    assert is_gone(process)


def test_closing_kills_the_process(running: tuple[Jobs, str, int]) -> None:
    jobs, name, process = running
    jobs.close()
    assert jobs.job(name).state is JobState.CANCELLED
    assert is_gone(process)


def test_a_process_that_is_killed_from_outside_fails_its_job(
    running: tuple[Jobs, str, int],
) -> None:
    jobs, name, process = running
    os.kill(process, 9)
    job = jobs.wait(name, BOUND_S)
    assert (job.state, job.failure_code) == ("failed", "job-failed")
    assert job.failure is not None
    assert "killed by SIGKILL" in job.failure


def test_the_process_does_not_outlive_a_daemon_that_is_killed(request: Any) -> None:
    program = (
        "from rigctl.jobs import Task, in_process\n"
        "task = Task(lambda text, share: print(text, flush=True))\n"
        "in_process('stand_in_work:never_ends', {})(task)\n"
    )
    here = str(request.path.parent)
    with subprocess.Popen(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": here},
    ) as daemon:
        try:
            assert daemon.stdout is not None
            ending = os.pidfd_open(int(daemon.stdout.readline()))
        finally:
            daemon.kill()
    gone, _, _ = select.select([ending], [], [], BOUND_S)
    os.close(ending)
    assert gone == [ending]


def is_gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    return False
