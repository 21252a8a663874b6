"""From shots of the simulated rig to the model, by REST: real frames, real jobs, real processes."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
import schemathesis

from rigctl.config import Configuration, StoreSection, load
from rigctl.daemon import Daemon, open_daemon
from rigctl.model.campaigns import campaign_poses
from rigctl.service.app import create_app
from rigctl.service.events import EventHub
from rigctl.store import ShotRecord, ShotState, Store

KEY = "campaign-key"
HEADERS = {"Authorization": f"Bearer {KEY}"}
OFFSETS_MM = (0.0, 4.0, 8.0, 12.0)
NYLON = "/api/v1/campaigns/nylon"
RESTITUTION = 0.74
"""Of the simulated spheres, at the speed for which it is stated."""
BOUND_S = 100.0

pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]
numbers = count()


def simulated(folder: Path) -> Configuration:
    return load().model_copy(update={"store": StoreSection(folder=str(folder))})


class Ends:
    """Waits until so many analyses have ended."""

    def __init__(self, store: Store) -> None:
        self._changed = threading.Condition()
        self._ended = 0
        store.listeners.add(self._hear)

    def _hear(self, record: ShotRecord) -> None:
        if record.state in {ShotState.ANALYSED, ShotState.REFUSED}:
            with self._changed:
                self._ended += 1
                self._changed.notify_all()

    def wait(self, number: int) -> None:
        with self._changed:
            assert self._changed.wait_for(lambda: self._ended >= number, BOUND_S)


def call(app: Any, method: str, path: str, **options: Any) -> httpx.Response:
    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://rig") as client:
            headers = HEADERS | options.pop("headers", {})
            return await client.request(method, path, headers=headers, **options)

    return asyncio.run(ask())


@pytest.fixture(scope="module")
def daemon(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Daemon]:
    with open_daemon(simulated(tmp_path_factory.mktemp("campaign") / "data")) as opened:
        yield opened


@pytest.fixture(scope="module")
def app(daemon: Daemon) -> Any:
    """Return the service over a campaign of four shots, of which three at least are measured.

    The laboratory draws its shots anew each time; one in sixty cannot be measured.
    """
    app, ends = create_app(daemon, KEY, EventHub()), Ends(daemon.store)
    for number, offset in enumerate(OFFSETS_MM):
        settings = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": offset}
        token = call(app, "POST", "/api/v1/rig/arm", json=settings).json()["arm_token"]
        body = {"arm_token": token, "campaign": "nylon"}
        fired = call(app, "POST", "/api/v1/shots", json=body, headers={"Idempotency-Key": token})
        assert daemon.rig.wait(fired.json()["shot"], BOUND_S).outcome is ShotState.STORED, number
    ends.wait(len(OFFSETS_MM))
    return app


def measured(app: Any) -> int:
    """Return how many of the shots were measured."""
    states = call(app, "GET", NYLON).json()["states"]
    assert sum(states.values()) == len(OFFSETS_MM)
    assert states["analysed"] >= len(OFFSETS_MM) - 1
    return int(states["analysed"])


def result(app: Any, daemon: Daemon, method: str, path: str, **options: Any) -> Any:
    """Ask, wait for the job, and return its result."""
    answer = call(app, method, path, **options)
    assert answer.status_code == 202, answer.text
    job = daemon.jobs.wait(answer.json()["job"], BOUND_S)
    assert job.state == "done", job
    return call(app, "GET", answer.headers["location"]).json()["result"]


def test_stored_shots_hold_the_poses_of_both_spheres(app: Any, daemon: Daemon) -> None:
    _, data = campaign_poses(daemon.store, "nylon")
    offsets = data.covariates["offset_mm"].tolist()
    assert len(offsets) == measured(app)
    assert offsets == [offset for offset in OFFSETS_MM if offset in offsets]
    seen = np.isfinite(data.position_sigma).all(axis=(2, 3))
    assert seen.sum(axis=1).min() > 10
    turned = data.rotation @ np.swapaxes(data.rotation, -1, -2)
    np.testing.assert_allclose(turned, np.broadcast_to(np.eye(3), turned.shape), atol=1e-9)


def test_a_fit_finds_the_restitution_of_the_simulated_spheres(app: Any, daemon: Daemon) -> None:
    order = {"name": f"fit-{next(numbers)}"}
    found = result(app, daemon, "POST", f"{NYLON}/fits", json=order)
    assert found["shots"] + len(found["rejected"]) == measured(app)
    assert found["parameters"]["e"]["value"] == pytest.approx(RESTITUTION, abs=0.02)
    saved = call(app, "GET", f"{NYLON}/fits/{order['name']}").json()
    assert saved["fit"]["parameters"] == found["parameters"]


@pytest.mark.parametrize("question", ["agreement", "structure", "ranking"])
def test_questions_are_answered_as_the_document_promises(
    app: Any, daemon: Daemon, question: str
) -> None:
    contract = schemathesis.openapi.from_asgi("/openapi.json", app)
    operation = contract["/api/v1/campaigns/{campaign}/" + question]["GET"]
    case = operation.Case(path_parameters={"campaign": "nylon"}, query={"with": ["image-scale"]})
    accepted = case.call_and_validate(headers=HEADERS)
    assert accepted.status_code == 202
    job = daemon.jobs.wait(accepted.json()["job"], BOUND_S)
    assert job.state == "done", job
    answered = case.call_and_validate(headers=HEADERS)
    assert answered.status_code == 200
    assert answered.json()["with"] == ["image-scale"]
    shown = contract["/api/v1/jobs/{job}"]["GET"].Case(path_parameters={"job": job.id})
    assert shown.call_and_validate(headers=HEADERS).json()["result"] == answered.json()


def test_analysing_again_adds_results_and_asks_for_fresh_answers(app: Any, daemon: Daemon) -> None:
    before = call(app, "GET", f"{NYLON}/ranking").json()
    again = result(app, daemon, "POST", f"{NYLON}/reanalyse")
    found = measured(app)
    assert again == {"shots": 4, "analysed": found, "refused": 4 - found}
    assert {shot.results for shot in daemon.store.shots(campaign="nylon")} == {2}
    after = call(app, "GET", f"{NYLON}/ranking")
    assert after.status_code == 202
    assert after.json()["job"] != before.get("job")
    assert call(app, "DELETE", after.headers["location"]).json()["state"] == "cancelled"


def test_a_verdict_under_way_is_cancelled_within_a_second(app: Any, daemon: Daemon) -> None:
    speaks = threading.Event()
    stop = daemon.jobs.listeners.add(lambda job: speaks.set() if job.progress else None)
    accepted = call(app, "POST", f"{NYLON}/explain")
    assert speaks.wait(BOUND_S)
    stop()
    deleted = call(app, "DELETE", accepted.headers["location"])
    assert deleted.json()["state"] == "cancelled"
    assert deleted.elapsed.total_seconds() < 1.0


def test_the_command_reads_the_campaign_by_its_name_while_the_daemon_runs(
    app: Any, daemon: Daemon, tmp_path: Path
) -> None:
    (tmp_path / "data").symlink_to(daemon.store.path)
    program = [sys.executable, "-c", "from rigctl.cli import main; main()", "model", "fit"]
    done = subprocess.run(
        [*program, "nylon"],
        cwd=tmp_path,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=BOUND_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"nylon: {measured(app)} shots")
