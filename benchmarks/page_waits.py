"""Waits of the page: first coefficients, first numbers, cancelled work, shots that are refused.

Parts of python -m benchmarks.page. Beside each first wait stand its steps and the CPU seconds that
daemon, workers and browser spent on it: on a host that does nothing else it lasts no longer than
these and what the rig itself takes.
"""

from __future__ import annotations

import os
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Protocol
from urllib.parse import quote

import httpx
from playwright.sync_api import Locator, Page
from playwright.sync_api import TimeoutError as PlaywrightTimeout

from benchmarks.cpu_seconds import of_process, of_tree

LONG_MS = 600_000
LOOK_MS = 50
GONE_MS = 5_000
REST_S, AT_REST, MOST_LOOKS = 2.0, 0.2, 60
"""Time between two looks, CPU seconds a second below which processes rest, and how many looks."""
CHOSEN = 7
"""So many cells are chosen."""
CANCELLED = 5
"""So many waits of a kind are cancelled."""
BROAD = {
    "campaign": "refused",
    "grid": {
        "pressure_a_kpa": {"first": 20.0, "last": 80.0, "count": 5, "spacing": "root"},
        "offset_mm": {"first": 0.0, "last": 20.0, "count": 6},
    },
}
"""The sweep that the page proposes first."""
GONE = """(name) => {
  const seen = (part) => part && part.checkVisibility();
  return !seen(document.querySelector(`[data-testid=${name}]`));
}"""

POINTS = """document.querySelector("[data-testid=story-points] .js-plotly-plot, "
  + "[data-testid=story-points].js-plotly-plot")?._fullData?.slice(0, 2)
  .map((one) => [...one.x, "", ...one.y].join()).join()"""
"""Points and line: the mean of a row has the points of another cell of it."""
NEW_POINTS = f"before => {{ const now = {POINTS}; return now && now !== before; }}"
GONE_AGAIN = "() => !document.querySelector('[data-testid=story-added]')"
FROM_EVENT = """([event, given]) => {
  const shown = (%s);
  window.waited = new Promise((done) => addEventListener(event, ({ timeStamp }) => {
    const look = () => shown(given)
      ? setTimeout(() => done(performance.now() - timeStamp), 0) : requestAnimationFrame(look);
    requestAnimationFrame(look);
  }, { once: true, capture: true }));
}"""
"""From the event of a person's hand, as the browser dates it, to the frame that shows what follows:
what the browser's driver does before it clicks is no wait of a person."""


class Daemon(Protocol):
    """What of a running daemon is used."""

    @property
    def rest(self) -> httpx.Client:
        """Its REST."""

    @property
    def pid(self) -> int:
        """Number of its process."""


@dataclass(frozen=True, slots=True)
class Waited:
    """One wait: how long, its steps with the second at which each began, and CPU seconds spent."""

    seconds: float
    steps: dict[str, float]
    daemon_s: float
    workers_s: float
    browser_s: float

    @property
    def cpu_s(self) -> float:
        """What all processes spent on it, s."""
        return self.daemon_s + self.workers_s + self.browser_s

    def chain(self) -> str:
        """Name the steps one after another."""
        return ", ".join(f"{step} {at:.2f} s" for step, at in self.steps.items())


class Meter:
    """Begins with its making; `read` says what was spent since."""

    def __init__(self, daemon: Daemon) -> None:
        self._pid, self._before = daemon.pid, self._spent(daemon.pid)
        self.began, self.began_at = time.perf_counter(), datetime.now(UTC)
        self.steps: dict[str, float] = {}

    def step(self, name: str) -> None:
        """Note when a step was seen first."""
        self.steps.setdefault(name, time.perf_counter() - self.began)

    def since(self, name: str, at: str) -> None:
        """Note a step by the time, ISO 8601, that the daemon gives it."""
        self.steps[name] = (datetime.fromisoformat(at) - self.began_at).total_seconds()

    def read(self) -> Waited:
        """Return what was waited."""
        seconds = time.perf_counter() - self.began
        spent = (after - b for after, b in zip(self._spent(self._pid), self._before, strict=True))
        daemon_s, workers_s, browser_s = spent
        return Waited(seconds, self.steps, daemon_s, workers_s, browser_s)

    @staticmethod
    def _spent(pid: int) -> tuple[float, float, float]:
        own, tree, ours = of_process(pid), of_tree(pid), of_tree(os.getpid())
        return own, tree - own, ours - tree - of_process(os.getpid())


def settle(daemon: Daemon) -> None:
    """Wait until the daemon and its workers rest: a page that is looked at has loaded long ago.

    Raises
    ------
    RuntimeError
        They do not, as while machine code is compiled: `rigctl precompile` does that beforehand.
    """
    spent = of_tree(daemon.pid)
    for _ in range(MOST_LOOKS):
        time.sleep(REST_S)
        before, spent = spent, of_tree(daemon.pid)
        if spent - before < AT_REST * REST_S:
            return
    raise RuntimeError(
        f"the daemon and its workers do not come to rest: {spent - before:.1f} s of the processor "
        f"in the last {REST_S:g} s"
    )


def cells_shown(page: Page, daemon: Daemon) -> list[Waited]:
    """Choose one cell of the story's map after another; return the waits for their points.

    The map is looked at before: what comes into sight with it is loaded by then.
    """
    page.get_by_test_id("map").scroll_into_view_if_needed()
    taken: list[Waited] = []
    for _ in range(CHOSEN):
        settle(daemon)
        points = page.evaluate(POINTS)
        cell = page.get_by_test_id("map").locator("[aria-pressed=false]").nth(len(taken))
        page.evaluate(FROM_EVENT % NEW_POINTS, ["click", points])
        meter = Meter(daemon)
        cell.click()
        taken.append(_from_event(page, meter))
    return taken


def undone(page: Page, daemon: Daemon) -> Waited:
    """Add the story's effect, then take it back by key; return the wait until that is shown."""
    page.locator("[data-testid^=add-]").first.click()
    page.get_by_test_id("story-added").wait_for(timeout=LONG_MS)
    settle(daemon)
    page.evaluate(FROM_EVENT % GONE_AGAIN, ["keydown", None])
    meter = Meter(daemon)
    page.keyboard.press("u")
    return _from_event(page, meter)


def _from_event(page: Page, meter: Meter) -> Waited:
    """Return the wait that `FROM_EVENT` has been asked for."""
    seconds = float(page.evaluate("window.waited")) / 1e3
    return replace(meter.read(), seconds=seconds)


def first_coefficients(page: Page, daemon: Daemon) -> Waited:
    """Fire the first shot by the page; return the wait from the click to its coefficients.

    Raises
    ------
    RuntimeError
        The store holds shots: their coefficients stand on the page already.
    """
    if _shots(daemon):
        raise RuntimeError("the first shot needs a fresh store: let this part run first")
    settle(daemon)
    page.get_by_test_id("arm").click()
    page.get_by_test_id("fire").wait_for()
    meter = Meter(daemon)
    page.get_by_test_id("fire").click()
    coefficients = page.get_by_test_id("coefficients")
    while not _seen(coefficients):
        for shot in _shots(daemon):
            meter.step(shot["state"])
    return meter.read()


def first_numbers(page: Page, daemon: Daemon, url: str, folder: Path) -> Waited:
    """Open the model of a campaign nobody has fitted; return the wait until its first numbers."""
    settle(daemon)
    meter = Meter(daemon)
    page.goto(f"{url}/model?folder={quote(str(folder))}", wait_until="commit")
    page.get_by_test_id("story-compare").wait_for(timeout=LONG_MS)
    waited = meter.read()
    job = daemon.rest.get("/api/v1/jobs").json()["jobs"][0]
    for step in ("created_at", "started_at", "ended_at"):
        meter.since(f"fit {step[:-3]}", job[step])
    return waited


def _seen(part: Locator) -> bool:
    """Say whether a part is seen, after a rest."""
    part.page.wait_for_timeout(LOOK_MS)
    return part.is_visible()


def cancelled(
    page: Page, daemon: Daemon, begin: Callable[[], None], names: tuple[str, str], times: int
) -> list[Waited]:
    """Begin long work and cancel it each time; return the waits, shortest first.

    Parameters
    ----------
    begin
        Begins work that lasts for several seconds.
    names
        Of the part of the page that shows the wait, and of what must be seen once it is gone: what
        was known before is kept.
    """
    taken, (wait, kept) = [], names
    for _ in range(times):
        begin()
        button = page.get_by_test_id(wait).locator("[data-testid^=cancel]")
        button.wait_for(timeout=LONG_MS)
        meter = Meter(daemon)
        # An answer that comes first takes the wait away, and its button with it.
        with suppress(PlaywrightTimeout):
            button.click(timeout=GONE_MS)
        page.wait_for_function(GONE, arg=wait)
        taken.append(meter.read())
        page.get_by_test_id(kept).first.wait_for()
    return sorted(taken, key=lambda one: one.seconds)


def refused_share(daemon: Daemon) -> Iterator[tuple[str, float]]:
    """Fire the sweep that the page proposes; yield its shots, and how many % were refused."""
    key = {"Idempotency-Key": uuid.uuid4().hex}
    started = daemon.rest.post("/api/v1/sweeps", json=BROAD, headers=key).raise_for_status().json()
    while daemon.rest.get(f"/api/v1/sweeps/{started['sweep']}").json()["state"] == "running":
        time.sleep(1.0)
    shots = [shot for shot in _shots(daemon) if shot["campaign"] == BROAD["campaign"]]
    while any(shot["state"] in {"stored", "analysing"} for shot in shots):
        time.sleep(1.0)
        shots = [shot for shot in _shots(daemon) if shot["campaign"] == BROAD["campaign"]]
    refused = sum(shot["state"] != "analysed" for shot in shots)
    yield "shots of the sweep that is proposed first", float(len(shots))
    yield "  of these refused", 100.0 * refused / max(len(shots), 1)


def _shots(daemon: Daemon) -> list[dict[str, str]]:
    found: list[dict[str, str]] = daemon.rest.get("/api/v1/shots?limit=100").json()["shots"]
    return found
