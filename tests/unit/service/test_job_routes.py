from __future__ import annotations

import json
import threading
from collections.abc import Callable
from typing import Any

import httpx
import pytest

from rigctl.jobs import Jobs, Task

JOBS = "/api/v1/jobs"
HEADERS = {"Authorization": "Bearer a-key-for-tests"}
WAIT_S = 120.0


@pytest.fixture
def hold(jobs: Jobs) -> Callable[[], str]:
    """Start a job that runs until it is cancelled; return its name."""

    def start() -> str:
        running = threading.Event()

        def work(task: Task) -> str:
            ends = threading.Event()
            task.on_cancel(ends.set)
            task.progress("half way", 0.5)
            running.set()
            ends.wait(WAIT_S)
            raise RuntimeError("cancelled")

        job = jobs.submit("explain", "nylon", work)
        assert running.wait(WAIT_S)
        return job.id

    return start


def test_a_running_job_shows_how_far_it_is(ask: Any, hold: Callable[[], str]) -> None:
    name = hold()
    shown = ask("GET", f"{JOBS}/{name}").json()
    assert shown["created_at"] <= shown["started_at"]
    assert {key: value for key, value in shown.items() if not key.endswith("_at")} == {
        "job": name,
        "kind": "explain",
        "campaign": "nylon",
        "state": "running",
        "progress": "half way",
        "share": 0.5,
        "failure": None,
        "enclosure": "",
        "failure_code": None,
        "result": None,
    }
    assert shown["ended_at"] is None


def test_the_list_has_every_job_without_its_result(
    ask: Any, jobs: Jobs, hold: Callable[[], str]
) -> None:
    done = jobs.submit("fits", "nylon", lambda _: json.dumps({"e": 0.7}))
    jobs.wait(done.id, WAIT_S)
    name = hold()
    listed = ask("GET", JOBS).json()["jobs"]
    assert [(job["job"], job["state"]) for job in listed] == [
        (done.id, "done"),
        (name, "running"),
    ]
    assert all("result" not in job for job in listed)
    assert ask("GET", f"{JOBS}/{done.id}").json()["result"] == {"e": 0.7}


def test_deleting_ends_a_job_and_deleting_it_again_changes_nothing(
    ask: Any, hold: Callable[[], str]
) -> None:
    name = hold()
    first, second = (ask("DELETE", f"{JOBS}/{name}") for _ in range(2))
    assert first.status_code == second.status_code == 200
    assert first.json() == second.json()
    assert first.json()["state"] == "cancelled"


@pytest.mark.parametrize("method", ["GET", "DELETE"])
def test_a_job_that_nobody_knows_is_not_found(ask: Any, method: str) -> None:
    answer = ask(method, f"{JOBS}/0123456789abcdef")
    assert (answer.status_code, answer.json()["code"]) == (404, "not-found")
    assert ask(method, f"{JOBS}/no-name-of-a-job").status_code == 422


def test_when_too_many_jobs_wait_the_next_is_refused(
    ask: Any, jobs: Jobs, hold: Callable[[], str], shoot: Callable[..., str], store: Any
) -> None:
    hold(), hold()
    for _ in range(16):
        jobs.submit("fits", "nylon", lambda _: "{}")
    shot = shoot("nylon")
    store.move(shot, "analysing")
    store.move(shot, "refused")
    answer = ask("POST", "/api/v1/campaigns/nylon/reanalyse")
    assert (answer.status_code, answer.json()["code"]) == (409, "jobs-full")
    assert (answer.json()["value"], answer.json()["limit"]) == ("16 waiting", "16")


def test_every_change_of_a_job_is_told_to_listeners(address: str, jobs: Jobs) -> None:
    with (
        httpx.Client(base_url=address, headers=HEADERS, timeout=WAIT_S) as client,
        client.stream("GET", "/api/v1/events") as stream,
    ):
        lines = stream.iter_lines()
        while next(lines) != "event: rig":
            pass
        job = jobs.submit("fits", "nylon", lambda _: json.dumps({"large": 1}))
        heard = []
        while len(heard) < 3:
            if next(lines) == "event: job":
                heard.append(json.loads(next(x for x in lines if x.startswith("data: "))[6:]))
    assert [(each["job"], each["state"]) for each in heard] == [
        (job.id, state) for state in ("queued", "running", "done")
    ]
    assert all("result" not in each for each in heard)
