"""Waits of the page: first coefficients, first numbers, cancelled work, shots that are refused.

Parts of python -m benchmarks.page.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol
from urllib.parse import quote

import httpx
from playwright.sync_api import Page

LONG_MS = 600_000
CANCELLED = 10
"""So many waits are cancelled: nine of ten must answer in time."""
BROAD = {
    "campaign": "refused",
    "grid": {
        "pressure_a_kpa": {"first": 20.0, "last": 80.0, "count": 5, "spacing": "root"},
        "offset_mm": {"first": 0.0, "last": 20.0, "count": 6},
    },
}
"""The sweep that the page proposes first."""
GONE = """() => {
  const seen = (part) => part && part.checkVisibility();
  return !seen(document.querySelector("[data-testid=explaining]"));
}"""


class Daemon(Protocol):
    """What of a running daemon is used."""

    @property
    def rest(self) -> httpx.Client:
        """Its REST."""


def first_coefficients(page: Page, daemon: Daemon) -> float:
    """Fire the first shot by the page; return the time from the click to its coefficients, s.

    Raises
    ------
    RuntimeError
        The store holds shots: their coefficients stand on the page already.
    """
    if _shots(daemon):
        raise RuntimeError("the first shot needs a fresh store: let this part run first")
    page.get_by_test_id("arm").click()
    page.get_by_test_id("fire").wait_for()
    began = time.perf_counter()
    page.get_by_test_id("fire").click()
    page.get_by_test_id("coefficients").wait_for(timeout=LONG_MS)
    return time.perf_counter() - began


def first_numbers(page: Page, url: str, folder: Path) -> float:
    """Open the model of a campaign nobody has fitted; return when its first numbers stand, s."""
    began = time.perf_counter()
    page.goto(f"{url}/model?folder={quote(str(folder))}", wait_until="commit")
    page.get_by_test_id("story-compare").wait_for(timeout=LONG_MS)
    return time.perf_counter() - began


def cancelled(page: Page) -> list[float]:
    """Have the open model explained and cancel it each time; return how long that took, s."""
    taken = []
    for _ in range(CANCELLED):
        page.get_by_test_id("explain").click()
        button = page.get_by_test_id("explaining").get_by_test_id("cancel-job")
        button.wait_for(timeout=LONG_MS)
        began = time.perf_counter()
        button.click()
        page.wait_for_function(GONE)
        taken.append(time.perf_counter() - began)
        page.get_by_test_id("explain").wait_for()
    return sorted(taken)


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


def ninth_of_ten(taken: list[float]) -> float:
    """Return the time that nine of ten stay within."""
    return taken[-1 - len(taken) // 10]
