"""How long a wait lasts: from jobs that ended, from the share that is done, or not known."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest

from rigctl.jobs import Job, JobState
from rigctl.jobs.duration import wait_of
from rigctl.jobs.job import utc_now

START = datetime(2026, 1, 1, tzinfo=UTC)


def at(seconds: float) -> datetime:
    return START + timedelta(seconds=seconds)


def job(kind: str = "picture", share: float | None = None, begun_s: float = 0.0) -> Job:
    running = JobState.RUNNING
    return Job("a" * 16, kind, "c", running, START, started_at=at(begun_s), share=share)


def done(seconds: float, state: JobState = JobState.DONE, kind: str = "picture") -> Job:
    return Job("b" * 16, kind, "c", state, START, started_at=START, ended_at=at(seconds))


def test_the_time_of_jobs_goes_on_evenly_whatever_the_hosts_clock_is_set_to(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Set(datetime):
        @classmethod
        def now(cls, tz: object = None) -> datetime:  # type: ignore[override]
            return datetime(2030, 1, 1, tzinfo=UTC)

    monkeypatch.setattr("rigctl.jobs.job.datetime", Set)
    monkeypatch.setattr("rigctl.jobs.job.time.monotonic", lambda: 1000.0)
    before = utc_now()
    monkeypatch.setattr("rigctl.jobs.job.time.monotonic", lambda: 1007.5)
    assert (utc_now() - before).total_seconds() == pytest.approx(7.5)
    assert before.year < 2030


def test_jobs_of_the_kind_say_how_long_one_takes() -> None:
    wait = wait_of(job(), [done(8), done(10), done(12), done(500, kind="explain")], at(4))
    assert (wait.gone_s, wait.left_s) == (4, 6)
    assert wait.share == pytest.approx(0.4)


def test_a_job_that_was_cancelled_says_nothing_of_how_long_one_takes() -> None:
    assert wait_of(job("reanalyse"), [done(1, JobState.CANCELLED)], at(4)).left_s is None


def test_time_in_the_queue_is_gone_but_brings_the_end_no_nearer() -> None:
    wait = wait_of(job(begun_s=5), [done(10)], at(7))
    assert (wait.gone_s, wait.left_s) == (7, 8)


def test_what_is_done_counts_more_than_other_jobs_from_the_half_on() -> None:
    assert wait_of(job(share=0.75), [done(10)], at(6)).left_s == pytest.approx(2)
    assert wait_of(job(share=0.25), [done(10)], at(6)).left_s == pytest.approx(4)


def test_an_estimate_is_given_up_once_it_is_over_and_never_stands_at_its_end() -> None:
    told = [wait_of(job(), [done(10)], at(0.5 * k)) for k in range(1, 60)]
    assert [wait.left_s for wait in told if wait.left_s is not None][-1] == 1
    assert sum(wait.left_s == 1 for wait in told) == 3
    assert all(wait.is_late for wait in told[20:])
