"""Sweeps as they are run: a daemon in its own process, killed, started again, its sweep resumed."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.invoked import Invoked, rigctl

pytestmark = pytest.mark.long

RIGCTL = [sys.executable, "-c", "from rigctl.cli import main; main()"]
WAIT_S = 60.0


def command(folder: Path, *arguments: str) -> Invoked:
    return rigctl(*arguments, folder=folder, key="")


@contextmanager
def daemon(folder: Path) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [*RIGCTL, "serve", "--port", "0"],
        cwd=folder,
        env={**os.environ, "RIGCTL_KEY": ""},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        assert process.stdout is not None
        assert "simulated" in process.stdout.readline()
        yield process
    finally:
        process.kill()
        process.communicate(timeout=WAIT_S)


@contextmanager
def events(folder: Path) -> Iterator[queue.SimpleQueue[dict[str, Any]]]:
    """Give the data of each event `sweep`, as it comes."""
    written = json.loads((folder / "data" / "service.json").read_text())
    told: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    headers = {"Authorization": f"Bearer {written['key']}"}
    listening = threading.Event()

    def listen() -> None:
        url = f"{written['url']}/api/v1/events"
        kind = ""
        try:
            with httpx.stream("GET", url, headers=headers, timeout=WAIT_S) as answer:
                for line in answer.iter_lines():
                    listening.set()
                    if line.startswith("event: "):
                        kind = line.removeprefix("event: ")
                    elif line.startswith("data: ") and kind == "sweep":
                        told.put(json.loads(line.removeprefix("data: ")))
        except httpx.TransportError:
            return

    threading.Thread(target=listen, daemon=True).start()
    assert listening.wait(WAIT_S)
    yield told


@pytest.mark.timeout(180)
def test_a_killed_daemon_comes_back_offers_its_sweep_and_fires_no_step_twice(
    tmp_path: Path,
) -> None:
    grid = ("--pressure-kpa", "30,50", "--offset-mm", "4,8", "--campaign", "killed")
    with daemon(tmp_path) as process, events(tmp_path) as told:
        started = command(tmp_path, "sweep", *grid, "--detach", "--json")
        assert started.returncode == 0, started.stderr
        name = json.loads(started.stdout)["sweep"]
        while told.get(timeout=WAIT_S)["counts"]["stored"] < 1:
            pass
        process.kill()
        process.wait(WAIT_S)
    with daemon(tmp_path) as process:
        assert process.stdout is not None
        offer = next(line for line in process.stdout if "waits" in line)
        assert f"sweep {name} waits" in offer
        assert f"rigctl sweep resume {name}" in offer
        found = json.loads(command(tmp_path, "sweep", "status", "--json").stdout)
        assert (found["sweep"], found["state"]) == (name, "paused")
        written = json.loads((tmp_path / "data" / "service.json").read_text())
        headers = {"Authorization": f"Bearer {written['key']}"}
        # A daemon that was killed begins latched, whether or not a shot was under way.
        release = {"reason": "looked at the tubes"}
        url = f"{written['url']}/api/v1/rig/release"
        assert httpx.post(url, headers=headers, json=release, timeout=WAIT_S).is_success
        with events(tmp_path) as told:
            resumed = command(tmp_path, "sweep", "resume")
            assert resumed.returncode == 0, resumed.stderr
            while told.get(timeout=WAIT_S)["state"] == "running":
                pass
        found = json.loads(command(tmp_path, "sweep", "status", "--json").stdout)
        shots = httpx.get(
            f"{written['url']}/api/v1/shots?campaign=killed", headers=headers, timeout=WAIT_S
        ).json()["shots"]
    assert found["state"] == "completed"
    lines = (tmp_path / "data/laboratory/truth/fires.jsonl").read_text().splitlines()
    flew = sum(shot["fired"] == "yes" for shot in shots)
    unknown = sum(shot["fired"] == "unknown" for shot in shots)
    assert flew <= len(lines) <= flew + unknown
    assert flew + unknown == 4
    assert sum(found["counts"][state] for state in ("stored", "lost", "unknown")) == 4
