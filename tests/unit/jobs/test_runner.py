from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import timedelta
from typing import Any

import pytest

from rigctl.errors import JobsFullError, NotFoundError, StoreError
from rigctl.jobs import Job, JobFailedError, Jobs, JobState, Task

BOUND_S = 60.0
Ended = Callable[[Job], Job]


def answer(task: Task) -> str:
    task.progress("thinking", 0.5)
    return '{"answer": 42}'


def states(heard: list[Job], job: Job) -> list[JobState]:
    return [each.state for each in heard if each.id == job.id]


def test_a_job_goes_from_queued_over_running_to_done_and_tells_every_step(
    jobs: Jobs, ended: Ended, clock: Any
) -> None:
    heard: list[Job] = []
    jobs.listeners.add(heard.append)
    asked = jobs.submit("ranking", "nylon", answer)
    job = ended(asked)
    assert (job.kind, job.subject, job.result) == ("ranking", "nylon", '{"answer": 42}')
    assert (job.progress, job.share) == ("thinking", 1.0)
    assert job.created_at == job.started_at == job.ended_at == clock.now
    jobs.close()
    assert states(heard, asked) == ["queued", "running", "running", "done"]
    assert heard[2].share == 0.5


@pytest.mark.parametrize(
    ("error", "failure", "code"),
    [
        (StoreError("the disk is full", todo="free it"), "the disk is full; free it", "store"),
        (JobFailedError("broke", because="analysis-input"), "broke", "analysis-input"),
        (JobFailedError("broke"), "broke", "job-failed"),
        (KeyError("x"), "KeyError('x')", "job-failed"),
    ],
)
def test_work_that_raises_is_failed_with_its_reason_and_code(
    jobs: Jobs, ended: Ended, error: Exception, failure: str, code: str
) -> None:
    def fail(_: Task) -> str:
        raise error

    job = ended(jobs.submit("fits", "nylon", fail))
    assert (job.state, job.result) == ("failed", None)
    assert (job.failure, job.failure_code) == (failure, code)
    assert ended(jobs.submit("fits", "nylon", answer)).state is JobState.DONE


def test_only_so_many_run_at_a_time_and_the_others_wait_their_turn(
    jobs: Jobs, ended: Ended, held: Any
) -> None:
    first = jobs.submit("fits", "a", held)
    assert held.runs.wait(BOUND_S)
    second = jobs.submit("fits", "b", answer)
    assert jobs.job(first.id).state is JobState.RUNNING
    assert jobs.job(second.id).state is JobState.QUEUED
    held.let_go()
    assert ended(second).state is JobState.DONE


def test_beyond_the_queue_no_job_is_taken_and_cancelling_one_makes_room(
    jobs: Jobs, held: Any
) -> None:
    jobs.submit("fits", "a", held)
    assert held.runs.wait(BOUND_S)
    waiting = [jobs.submit("fits", "a", answer) for _ in range(2)]
    with pytest.raises(JobsFullError, match=r"found 2 waiting, allowed 2"):
        jobs.submit("fits", "a", answer)
    assert jobs.cancel(waiting[0].id).state is JobState.CANCELLED
    jobs.submit("fits", "a", answer)


def test_a_cancelled_job_that_waited_is_never_run(jobs: Jobs, ended: Ended, held: Any) -> None:
    ran = threading.Event()

    def note(_: Task) -> str:
        ran.set()
        return "{}"

    jobs.submit("fits", "a", held)
    assert held.runs.wait(BOUND_S)
    job = jobs.submit("fits", "a", note)
    assert jobs.cancel(job.id).state is JobState.CANCELLED
    held.let_go()
    ended(jobs.submit("fits", "a", answer))
    assert not ran.is_set()
    assert jobs.job(job.id).started_at is None


def test_a_running_job_is_ended_by_cancelling_it_and_has_no_failure(jobs: Jobs, held: Any) -> None:
    job = jobs.submit("fits", "a", held)
    assert held.runs.wait(BOUND_S)
    last = jobs.cancel(job.id)
    assert (last.state, last.failure, last.result) == ("cancelled", None, None)


def test_work_without_a_callback_ends_at_its_next_step_after_it_is_cancelled(
    jobs: Jobs, ended: Ended
) -> None:
    runs, never, steps = threading.Event(), threading.Event(), list[str]()

    def export(task: Task) -> str:
        for number in range(3):
            task.progress(f"writing file {number}", number / 3)
            steps.append(f"file {number}")
            runs.set()
            assert any(task.cancelled or never.wait(0.01) for _ in range(3000))
        return "{}"

    job = jobs.submit("export", "a", export)
    assert runs.wait(BOUND_S)
    jobs.cancel(job.id)
    assert ended(job).state is JobState.CANCELLED
    assert steps == ["file 0"]


def test_a_job_that_has_ended_is_left_as_it_is(jobs: Jobs, ended: Ended) -> None:
    job = ended(jobs.submit("fits", "a", answer))
    assert jobs.cancel(job.id) == job


def test_the_same_question_gets_the_same_job_while_it_runs_and_when_it_is_done(
    jobs: Jobs, ended: Ended, held: Any
) -> None:
    first = jobs.submit("ranking", "a", held, key="question")
    assert jobs.submit("ranking", "a", answer, key="question").id == first.id
    held.let_go()
    ended(first)
    again = jobs.submit("ranking", "a", answer, key="question")
    assert (again.id, again.state) == (first.id, "done")
    assert jobs.submit("ranking", "a", answer, key="another").id != first.id


def test_a_question_whose_job_failed_or_was_cancelled_is_asked_afresh(
    jobs: Jobs, ended: Ended, held: Any
) -> None:
    def fail(_: Task) -> str:
        raise StoreError("the disk is full")

    failed = ended(jobs.submit("ranking", "a", fail, key="question"))
    second = jobs.submit("ranking", "a", held, key="question")
    assert second.id != failed.id
    assert held.runs.wait(BOUND_S)
    jobs.cancel(second.id)
    third = jobs.submit("ranking", "a", answer, key="question")
    assert ended(third).state is JobState.DONE


def test_the_oldest_of_the_ended_jobs_are_forgotten_first(jobs: Jobs, ended: Ended) -> None:
    done = [ended(jobs.submit("fits", "a", answer)) for _ in range(4)]
    assert [job.id for job in jobs.jobs()] == [job.id for job in done[1:]]
    with pytest.raises(NotFoundError, match="no such job"):
        jobs.job(done[0].id)


def test_large_results_are_forgotten_sooner_and_the_latest_is_kept_however_large(
    jobs: Jobs, ended: Ended
) -> None:
    done = [ended(jobs.submit("fits", "a", lambda _: "x" * 40)) for _ in range(3)]
    assert [job.id for job in jobs.jobs()] == [job.id for job in done[1:]]
    large = ended(jobs.submit("fits", "a", lambda _: "x" * 500))
    assert [job.id for job in jobs.jobs()] == [large.id]


def test_an_ended_job_is_forgotten_after_a_day_and_one_that_runs_is_not(
    jobs: Jobs, ended: Ended, held: Any, clock: Any
) -> None:
    done = ended(jobs.submit("fits", "a", answer, key="question"))
    runs = jobs.submit("fits", "a", held)
    assert held.runs.wait(BOUND_S)
    clock.now += timedelta(hours=24)
    assert {job.id for job in jobs.jobs()} == {done.id, runs.id}
    clock.now += timedelta(seconds=1)
    assert [job.id for job in jobs.jobs()] == [runs.id]
    assert jobs.submit("fits", "a", answer, key="question").id != done.id


def test_closing_cancels_what_runs_and_what_waits_and_takes_no_more(jobs: Jobs, held: Any) -> None:
    both = [jobs.submit("fits", "a", held), jobs.submit("fits", "a", answer)]
    assert held.runs.wait(BOUND_S)
    jobs.close()
    assert [jobs.job(job.id).state for job in both] == ["cancelled", "cancelled"]
    with pytest.raises(JobsFullError):
        jobs.submit("fits", "a", answer)
    jobs.close()


def test_what_is_asked_of_a_task_after_it_was_cancelled_is_done_at_once() -> None:
    called: list[str] = []
    task = Task(lambda text, share: None)
    task.on_cancel(lambda: called.append("before"))
    task.cancel()
    task.cancel()
    task.on_cancel(lambda: called.append("after"))
    assert called == ["before", "after"]
