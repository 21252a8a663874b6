"""A daemon with the simulated rig and Chromium in front of it, to measure and to test the page."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
from playwright.sync_api import Browser, Page, sync_playwright

from benchmarks.cpu_seconds import ran_and_waited

KEY = "a-key-for-the-benchmark"
RIGCTL = Path(sys.executable).with_name("rigctl")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
SWITCHES = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
SETTINGS = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0}
LONG_S = 300.0


@dataclass(frozen=True, slots=True)
class FireRequest:
    """How long a fire request took until its answer, s.

    And, of the daemon's threads meanwhile, how long they ran and waited for a processor, s.
    """

    took_s: float
    ran_s: float
    waited_s: float


@dataclass(frozen=True, slots=True)
class Served:
    """A daemon: its address, and its REST."""

    url: str
    rest: httpx.Client
    pid: int

    def fire(self) -> FireRequest:
        """Fire one shot, wait for its end, and return how long the fire request took."""
        token = self.rest.post("/api/v1/rig/arm", json=SETTINGS).raise_for_status().json()
        body = {"arm_token": token["arm_token"]}
        headers = {"Idempotency-Key": uuid.uuid4().hex}
        ran, waited = ran_and_waited(self.pid)
        began = time.perf_counter()
        fired = self.rest.post("/api/v1/shots", json=body, headers=headers)
        took = time.perf_counter() - began
        after = ran_and_waited(self.pid)
        fired.raise_for_status()
        until = time.monotonic() + LONG_S
        while (rig := self.rest.get("/api/v1/rig").json())["state"] != "idle":
            if rig["latch_reason"] is not None or time.monotonic() > until:
                raise RuntimeError(f"the rig is {rig['state']}: {rig['latch_reason']}")
            time.sleep(0.05)
        return FireRequest(took, after[0] - ran, after[1] - waited)

    def job(self) -> dict[str, Any]:
        """Return the job that was submitted last."""
        jobs: list[dict[str, Any]] = self.rest.get("/api/v1/jobs").json()["jobs"]
        return jobs[-1]


def started(
    folder: Path, options: Sequence[str] = ("--port", "0"), more: Mapping[str, str] | None = None
) -> tuple[subprocess.Popen[str], str]:
    """Start a daemon in a folder, with `more` in its environment; return it and its address."""
    process = subprocess.Popen(
        [str(RIGCTL), "serve", *options],
        cwd=folder,
        env={**os.environ, "RIGCTL_KEY": KEY, **(more or {})},
        stdout=subprocess.PIPE,
        text=True,
    )
    printed = "" if process.stdout is None else process.stdout.readline()
    if "?key=" not in printed:
        process.kill()
        process.communicate()
        raise RuntimeError(f"the daemon has printed no address but {printed!r}")
    return process, printed.split(" at ")[1].partition("/?key=")[0].strip()


@contextmanager
def served(folder: Path, more: Mapping[str, str] | None = None) -> Iterator[Served]:
    """Run a daemon for the time of the block, with `more` in its environment."""
    process, url = started(folder, more=more)
    try:
        bearer = {"Authorization": f"Bearer {KEY}"}
        with httpx.Client(base_url=url, headers=bearer, timeout=LONG_S) as rest:
            yield Served(url, rest, process.pid)
    finally:
        process.terminate()
        process.communicate(timeout=60)


@contextmanager
def launched(*, aside: bool) -> Iterator[Browser]:
    """Start Chromium; aside: on the last core alone, as it would stand on another machine."""
    everywhere = os.sched_getaffinity(0)
    # Chromium and its driver inherit the cores of the process that starts them.
    os.sched_setaffinity(0, {max(everywhere)} if aside else everywhere)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=SWITCHES)
        os.sched_setaffinity(0, everywhere)
        yield browser
        browser.close()


def opened(browser: Browser, url: str, asked: list[str]) -> tuple[Page, float]:
    """Open the page as one who never was there; return it, and when it could be used, s."""
    page = browser.new_context(viewport={"width": 1280, "height": 800}).new_page()
    page.set_default_timeout(1e3 * LONG_S)
    page.on("request", lambda request: asked.append(request.url))
    began = time.perf_counter()
    page.goto(f"{url}/?key={KEY}", wait_until="commit")
    page.wait_for_function("window.did_handshake && document.querySelector('[data-testid=arm]')")
    return page, time.perf_counter() - began
